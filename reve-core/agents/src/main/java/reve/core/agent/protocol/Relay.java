// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

/**
 * Another server of this process, such as the web server, that passes the messages of a connection
 * on to its client. For any thread. The methods return without waiting.
 */
public interface Relay {

    /**
     * Notifies the relay that the client was admitted, with its role, world and name. Called before
     * the welcome is sent.
     */
    void welcomed(Role role, String world, String client);

    /**
     * Notifies the relay that the connection ends. Only the messages that already wait are still
     * sent.
     */
    void ended();
}
