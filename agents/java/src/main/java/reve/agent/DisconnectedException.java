// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.net.InetSocketAddress;
import java.util.Optional;

/**
 * Reports that the connection has ended. The code is the server's reason, or {@code lost} if there
 * was none.
 */
public final class DisconnectedException extends AgentException {

    private static final long serialVersionUID = 1L;

    private final transient Optional<InetSocketAddress> address;

    DisconnectedException(String code, String message, Optional<String> hint) {
        this(code, message, hint, Optional.empty());
    }

    private DisconnectedException(
            String code,
            String message,
            Optional<String> hint,
            Optional<InetSocketAddress> address) {
        super(code, message, hint);
        this.address = address;
    }

    static DisconnectedException of(ServerMessage.Bye bye) {
        return new DisconnectedException(
                bye.code(),
                bye.message(),
                bye.hint(),
                bye.address().map(DisconnectedException::parsed));
    }

    static InetSocketAddress parsed(String address) {
        int colon = address.lastIndexOf(':');
        if (colon < 1) {
            throw new IllegalArgumentException("'" + address + "', expected HOST:PORT");
        }
        return InetSocketAddress.createUnresolved(
                address.substring(0, colon), Integer.parseInt(address.substring(colon + 1)));
    }

    /** Returns the address of the server that has the world, if the server named another server. */
    public Optional<InetSocketAddress> address() {
        return address;
    }
}
