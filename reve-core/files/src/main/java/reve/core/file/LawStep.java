// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

/**
 * A change of a world's laws at a frame of a run.
 *
 * @param frame the first frame with the change; the first frame of a run is 1
 * @param law the law, with its parameters; for a law as text also the text
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
        /** Loads the law's text, which replaces a loaded text of the same name. */
        TEXT
    }
}
