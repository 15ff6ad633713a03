// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.List;

/**
 * One run of an experiment.
 *
 * @param point the values by which the run differs from the other runs
 * @param world the world of the run
 * @param frames number of frames
 * @param steps changes of laws, in the order of their frames
 * @param measures the values to measure, in the order of the file
 * @param agents programs that join as agents
 */
public record RunPlan(
        RunPoint point,
        WorldDescription world,
        long frames,
        List<LawStep> steps,
        List<Measure> measures,
        List<AgentProgram> agents) {
    /** Copies the lists. */
    public RunPlan {
        steps = List.copyOf(steps);
        measures = List.copyOf(measures);
        agents = List.copyOf(agents);
    }
}
