// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import java.util.concurrent.atomic.LongAdder;

/** What {@link AgentStats} is made of. Any thread. */
final class Counters {

    final LongAdder connections = new LongAdder();
    final LongAdder open = new LongAdder();
    final LongAdder agents = new LongAdder();
    final LongAdder joined = new LongAdder();
    final LongAdder lines = new LongAdder();
    final LongAdder errors = new LongAdder();
    final LongAdder perceptions = new LongAdder();
    final LongAdder actsAccepted = new LongAdder();
    final LongAdder actsRefused = new LongAdder();
    final LongAdder cut = new LongAdder();

    AgentStats read(long unrecorded) {
        return new AgentStats(
                connections.sum(),
                open.sum(),
                agents.sum(),
                joined.sum(),
                lines.sum(),
                errors.sum(),
                perceptions.sum(),
                actsAccepted.sum(),
                actsRefused.sum(),
                cut.sum(),
                unrecorded);
    }
}
