// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import java.util.concurrent.atomic.LongAdder;

/** What a server counts. Any thread. */
public final class Counters {

    /** Connections accepted so far. */
    public final LongAdder connections = new LongAdder();

    /** Connections that are open. */
    public final LongAdder open = new LongAdder();

    /** Agents with a body. */
    public final LongAdder agents = new LongAdder();

    /** Agents welcomed so far. */
    public final LongAdder joined = new LongAdder();

    /** Messages received. */
    public final LongAdder lines = new LongAdder();

    /** Messages refused with an error. */
    public final LongAdder errors = new LongAdder();

    /** Perceptions handed to connections. */
    public final LongAdder perceptions = new LongAdder();

    /** Acts that took effect. */
    public final LongAdder actsAccepted = new LongAdder();

    /** Acts that did not. */
    public final LongAdder actsRefused = new LongAdder();

    /** Connections that the server ended for breaking a limit. */
    public final LongAdder cut = new LongAdder();
}
