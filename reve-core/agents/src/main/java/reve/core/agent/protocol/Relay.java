// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

/**
 * A server of this process that passes the lines of a connection on to its client, such as a page.
 * Any thread; the methods return without waiting.
 */
public interface Relay {

    /** Takes what the session decided about the client. Called before its welcome is sent. */
    void welcomed(Role role, String world, String client);

    /** Takes the end of the connection, after which only waiting messages follow. */
    void ended();
}
