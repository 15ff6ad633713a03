// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.List;
import java.util.Optional;
import java.util.OptionalInt;
import java.util.OptionalLong;

/**
 * The server's answer to a join.
 *
 * @param role "agent", "control" or "observer"
 * @param body name of the agent's body; empty for other roles
 * @param frame number of the frame in which the agent joined
 * @param rate frames per second
 * @param encoding "json" or "msgpack"
 * @param lockStep the interval and the deadline of an agent in lock-step
 * @param session present if the join requested grace
 * @param resumed true if a session was resumed after its connection broke
 * @param cameras names of the cameras of the agent's body
 */
public record Welcome(
        OptionalLong id,
        int protocol,
        String role,
        String agent,
        Optional<String> body,
        String world,
        long frame,
        int rate,
        String encoding,
        Optional<LockStep> lockStep,
        Optional<Ticket> session,
        boolean resumed,
        Limits limits,
        List<String> cameras)
        implements ServerMessage {

    /** Copies the list. */
    public Welcome {
        cameras = List.copyOf(cameras);
    }

    /**
     * The token with which a new connection resumes the session. The session can be resumed within
     * {@code graceSeconds} after the old connection broke.
     *
     * @param servers HOST:PORT of other servers of a cluster at which the session can be resumed if
     *     this one does not answer
     */
    public record Ticket(String token, double graceSeconds, List<String> servers) {

        /** Copies the list. */
        public Ticket {
            servers = List.copyOf(servers);
        }
    }

    /**
     * Limits of the server. A limit that the server does not have is empty.
     *
     * @param lineBytes maximum length of a message
     * @param messagesPerSecond maximum rate of messages, per second of the clock; in lock-step, per
     *     second of world time if world time is faster. The server delays further messages
     * @param actsInFlight maximum number of commands without a result
     * @param idleSeconds silence after which the server sends a ping; the client answers it
     *     automatically
     * @param graceSeconds maximum time of grace
     * @param items maximum number of items created by the agent's actions
     * @param worldItems maximum number of items created by actions of all agents
     * @param eventBytes maximum size of events that the agent's actions raise [byte/s of world
     *     time]
     * @param worldEventBytes maximum size of events that actions of all agents raise [byte/s of
     *     world time]
     */
    public record Limits(
            int lineBytes,
            int messagesPerSecond,
            int actsInFlight,
            double idleSeconds,
            double graceSeconds,
            OptionalInt items,
            OptionalInt worldItems,
            OptionalInt eventBytes,
            OptionalInt worldEventBytes) {}
}
