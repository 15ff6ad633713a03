// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

/**
 * A change of a world's laws at a frame of a run.
 *
 * @param frame the first frame with the change; the first frame of a run is 1
 * @param law the law, with the parameters and, for a law as text, the text that the change uses
 */
public record LawStep(long frame, Change change, LawReference law) {
    /** The kind of change. */
    public enum Change {
        /** Loads the law by its name. */
        LOAD,
        /** Unloads the law. */
        UNLOAD,
        /** Sets parameters of the loaded law. */
        SET,
        /** Loads the law's text, in place of a loaded text of the same name. */
        TEXT
    }
}
