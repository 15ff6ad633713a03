// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import java.util.Optional;

/** A connection ends, and why. Without a stack trace: a hostile client can cause many. */
final class Ending extends Exception {

    private static final long serialVersionUID = 1L;

    private final String code;
    private final transient Optional<String> hint;
    private final boolean cut;

    private Ending(String code, String message, Optional<String> hint, boolean cut) {
        super(message, null, false, false);
        this.code = code;
        this.hint = hint;
        this.cut = cut;
    }

    /** Nobody did anything wrong. */
    static Ending regular(String code, String message) {
        return new Ending(code, message, Optional.empty(), false);
    }

    /** The hello cannot be granted; the hint says what to change. */
    static Ending refused(String code, String message, String hint) {
        return new Ending(code, message, Optional.of(hint), false);
    }

    /**
     * The same whoever or whatever is called that: not every client may know which items there are.
     */
    static Ending nameTaken(String name) {
        return refused(
                "name-taken",
                "another client, or an item of the world, is called " + Text.quote(name),
                "say hello with another name");
    }

    /** The client broke a limit. */
    static Ending cut(String code, String message) {
        return new Ending(code, message, Optional.empty(), true);
    }

    Optional<String> hint() {
        return hint;
    }

    String code() {
        return code;
    }

    boolean isCut() {
        return cut;
    }

    ServerMessage.Bye bye() {
        return new ServerMessage.Bye(code, getMessage(), hint);
    }
}
