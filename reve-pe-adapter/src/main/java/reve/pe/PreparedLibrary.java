// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.nio.charset.StandardCharsets;
import java.util.List;

/**
 * A law library that is opened and checked, and can be activated quickly. The caller owns it until
 * {@link PhysicsEngine#loadPhysicsLaw} takes it. A library that no engine takes is closed by the
 * caller, on any thread, before the engine that prepared it is closed.
 */
public interface PreparedLibrary extends AutoCloseable {
    /** Maximum size of a law library [bytes]. */
    int MAX_BYTES = 1 << 28;

    /** Maximum size of a law in Python [bytes]. */
    int MAX_PYTHON_BYTES = 1 << 20;

    /** Maximum size of a law as text [bytes]. */
    int MAX_TEXT_BYTES = 65_536;

    /** Suffix of file names of laws as text. */
    String TEXT_ENDING = ".law";

    /** Suffix of file names of laws in Python. */
    String PYTHON_ENDING = ".py";

    /**
     * Beginnings of lines, of which every file with laws in Python contains one: before the
     * function of a law, and before the function of a field. No law as text contains such a line.
     */
    List<String> PYTHON_SIGNS = List.of("@vesper.law", "@vesper.field");

    /**
     * Returns whether a library is a law as text, which cannot harm the process. Native code begins
     * with the magic bytes of ELF; Python code contains one of {@link #PYTHON_SIGNS}.
     */
    static boolean isText(byte[] library) {
        return !isNative(library) && !isPython(library);
    }

    /** Returns whether a library is a file with laws in Python. */
    static boolean isPython(byte[] library) {
        if (isNative(library)) {
            return false;
        }
        String text = new String(library, StandardCharsets.ISO_8859_1);
        return PYTHON_SIGNS.stream()
                .anyMatch(
                        sign ->
                                text.startsWith(sign)
                                        || text.contains("\n" + sign)
                                        || text.contains("\r" + sign));
    }

    private static boolean isNative(byte[] library) {
        return library.length >= 4
                && library[0] == 0x7f
                && library[1] == 'E'
                && library[2] == 'L'
                && library[3] == 'F';
    }

    /** Returns the library's own name. */
    String name();

    /**
     * Returns the versions of the programs on which the results of the library depend, for example
     * {@code Python 3.11.2, NumPy 1.24.2}. Empty for native code and texts, whose results depend on
     * their bytes only.
     */
    default String versions() {
        return "";
    }

    /** Returns the SHA-256 of the library's bytes, 64 lower-case hexadecimal digits. */
    String sha256();

    /** Returns the library's bytes; the caller must not change them. */
    byte[] bytes();

    /**
     * Returns whether an engine may take this library: no engine has taken it, and it is not
     * closed. For any thread.
     */
    boolean isFree();

    /** Frees the library if no engine took it. Idempotent. */
    @Override
    void close();
}
