// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import java.util.Optional;

/** A connection ends, and why. Without a stack trace: a hostile client can cause many. */
public final class CloseReason extends Exception {

    private static final long serialVersionUID = 1L;

    /** The code that the protocol lists. */
    private final String code;

    private final transient Optional<String> hint;

    /** True if the client did something wrong. */
    private final boolean cut;

    private CloseReason(String code, String message, Optional<String> hint, boolean cut) {
        super(message, null, false, false);
        this.code = code;
        this.hint = hint;
        this.cut = cut;
    }

    /** Nobody did anything wrong. */
    public static CloseReason regular(String code, String message) {
        return new CloseReason(code, message, Optional.empty(), false);
    }

    /** The hello cannot be granted; the hint says what to change. */
    public static CloseReason refused(String code, String message, String hint) {
        return new CloseReason(code, message, Optional.of(hint), false);
    }

    /**
     * The same whoever or whatever is called that: not every client may know which items there are.
     */
    public static CloseReason nameTaken(String name) {
        return refused(
                "name-taken",
                "another client, or an item of the world, is called " + Text.quote(name),
                "say hello with another name");
    }

    /** The client broke a limit. */
    public static CloseReason cut(String code, String message) {
        return new CloseReason(code, message, Optional.empty(), true);
    }

    /** The server has all the clients that it takes. */
    public static CloseReason serverFull(int mostClients) {
        return cut(
                "too-many-connections",
                "the server has " + mostClients + " clients, which is all it takes");
    }

    /** The server may send nothing without a record. */
    public static CloseReason notRecorded() {
        return refused(
                "not-recorded",
                "the server sends nothing without a record, and cannot write it now",
                "try again later");
    }

    /** Returns what the client can do about it. */
    public Optional<String> hint() {
        return hint;
    }

    /** Returns the code of the protocol. */
    public String code() {
        return code;
    }

    /** Returns true if the client broke a limit. */
    public boolean isCut() {
        return cut;
    }

    /** Returns the last message to the client. */
    public ServerMessage.Bye bye() {
        return new ServerMessage.Bye(code, getMessage(), hint);
    }
}
