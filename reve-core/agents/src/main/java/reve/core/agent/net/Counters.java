// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import java.util.concurrent.atomic.LongAdder;

/** Counters of a server. For any thread. */
public final class Counters {

    /** Accepted connections so far. */
    public final LongAdder connections = new LongAdder();

    /** Connections that are open now. */
    public final LongAdder open = new LongAdder();

    /** Agents with a body now. */
    public final LongAdder agents = new LongAdder();

    /** Agents that were sent a welcome so far. */
    public final LongAdder joined = new LongAdder();

    /** Messages received so far. */
    public final LongAdder lines = new LongAdder();

    /** Messages refused with an error so far. */
    public final LongAdder errors = new LongAdder();

    /** Perceptions queued for connections so far. */
    public final LongAdder perceptions = new LongAdder();

    /** Acts that took effect so far. */
    public final LongAdder actsAccepted = new LongAdder();

    /** Acts that were refused so far. */
    public final LongAdder actsRefused = new LongAdder();

    /** Connections that the server ended because the client exceeded a limit, so far. */
    public final LongAdder cut = new LongAdder();
}
