// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

/** A receiver of the progress of runs. Called by the threads of all runs. */
public interface RunProgress {
    /**
     * Reports that a part of a run has been done.
     *
     * @param part fraction of the run
     */
    void advanced(double part);

    /** Reports that a run has ended. */
    void ended(RunResult result);
}
