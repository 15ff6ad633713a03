// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;
import java.util.Map;

/** Size of the designer's symbols in messages [bytes]. */
final class SymbolSizes {
    /** Size of a number or a truth value, with the separator. */
    private static final int PLAIN = 24;

    /** Size of the quotation marks and the separator of a text. */
    private static final int AROUND_TEXT = 3;

    /** Size of a control character, which JSON escapes: {@code \}{@code u0001}. */
    private static final int ESCAPED = 6;

    private SymbolSizes() {}

    /** Returns the size of symbols by name. */
    static long of(Map<String, Object> symbols) {
        long bytes = 0;
        for (Map.Entry<String, Object> symbol : symbols.entrySet()) {
            bytes += of(symbol.getKey(), symbol.getValue());
        }
        return bytes;
    }

    /** Returns the size of a symbol with this name. */
    static long of(String name, Object value) {
        return of(name) + of(value);
    }

    private static long of(Object value) {
        return switch (value) {
            case String text -> AROUND_TEXT + characters(text);
            case List<?> list -> {
                long bytes = AROUND_TEXT;
                for (int i = 0; i < list.size(); i++) {
                    bytes += of(list.get(i));
                }
                yield bytes;
            }
            default -> PLAIN;
        };
    }

    private static long characters(String text) {
        long bytes = 0;
        for (int i = 0; i < text.length(); i++) {
            char c = text.charAt(i);
            if (c < ' ') {
                bytes += ESCAPED;
            } else if (c == '"' || c == '\\') {
                bytes += 2;
            } else {
                bytes += c < 0x80 ? 1 : 3;
            }
        }
        return bytes;
    }
}
