// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import java.util.Optional;

/**
 * The reason why the server ends a connection, thrown as an exception. The exception has no stack
 * trace, because stack traces are expensive and a hostile client can cause many exceptions.
 */
public final class CloseReason extends Exception {

    private static final long serialVersionUID = 1L;

    /** Code of the reason in the protocol. */
    private final String code;

    private final transient Optional<String> hint;

    /** Address of the server that has the client's world, if it is another server. */
    private final transient Optional<String> address;

    /** True if the client exceeded a limit. */
    private final boolean cut;

    private CloseReason(String code, String message, Optional<String> hint, boolean cut) {
        this(code, message, hint, Optional.empty(), cut);
    }

    private CloseReason(
            String code,
            String message,
            Optional<String> hint,
            Optional<String> address,
            boolean cut) {
        super(message, null, false, false);
        this.code = code;
        this.hint = hint;
        this.address = address;
        this.cut = cut;
    }

    /** Returns a reason that is not an error of the client. */
    public static CloseReason regular(String code, String message) {
        return new CloseReason(code, message, Optional.empty(), false);
    }

    /** Returns the reason for refusing a hello; the hint says what the client must change. */
    public static CloseReason refused(String code, String message, String hint) {
        return new CloseReason(code, message, Optional.of(hint), false);
    }

    /**
     * Returns the reason for refusing a client's name that is in use. The message does not say
     * whether a client or an item has the name, because not every client is allowed to know the
     * items.
     */
    public static CloseReason nameTaken(String name) {
        return refused(
                "name-taken",
                "another client, or an item of the world, is called " + Text.quote(name),
                "say hello with another name");
    }

    /**
     * Returns the reason for sending a client to another server.
     *
     * @param address HOST:PORT of the server that has the world
     */
    public static CloseReason moved(String world, String address) {
        return new CloseReason(
                "moved",
                "the server at " + address + " has the world " + Text.quote(world),
                Optional.of("say hello there"),
                Optional.of(address),
                false);
    }

    /**
     * Returns the reason for ending the connection of a client whose world moves to another server.
     *
     * @param address HOST:PORT of the server that the client shall ask for the world
     */
    public static CloseReason moving(String world, String address) {
        return new CloseReason(
                "moved",
                "the world " + Text.quote(world) + " moves to another server",
                Optional.of("say hello to the server at " + address),
                Optional.of(address),
                false);
    }

    /** Returns a reason for a client that exceeded a limit. */
    public static CloseReason cut(String code, String message) {
        return new CloseReason(code, message, Optional.empty(), true);
    }

    /**
     * Returns the reason for refusing a client because the server has its maximum number of
     * clients.
     */
    public static CloseReason serverFull(int mostClients) {
        return cut(
                "too-many-connections",
                "the server has " + mostClients + " clients, which is all it takes");
    }

    /**
     * Returns the reason for ending a connection because its messages cannot be written to the
     * required audit record.
     */
    public static CloseReason notRecorded() {
        return refused(
                "not-recorded",
                "the server sends nothing without a record, and cannot write it now",
                "try again later");
    }

    /** Returns what the client can do to remove the reason; empty if it can do nothing. */
    public Optional<String> hint() {
        return hint;
    }

    /** Returns the code of the reason in the protocol. */
    public String code() {
        return code;
    }

    /** Returns whether the client exceeded a limit. */
    public boolean isCut() {
        return cut;
    }

    /** Returns the message {@code bye} with this reason. It is the last message to the client. */
    public ServerMessage.Bye bye() {
        return new ServerMessage.Bye(code, getMessage(), hint, address);
    }
}
