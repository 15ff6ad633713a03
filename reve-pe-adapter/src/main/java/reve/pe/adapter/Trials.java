// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import java.util.List;

/**
 * Trials (tests) of new versions of laws before these versions replace the loaded versions. For the
 * world's thread only.
 */
public interface Trials {
    /** The value for a world without trials, in which new versions take over at once. */
    Trials NONE =
            new Trials() {
                @Override
                public boolean areDue(LawLibrary library) {
                    return false;
                }

                @Override
                public boolean areDueForParameters() {
                    return false;
                }

                @Override
                public void begin(long frame, List<NewVersion> versions) {
                    throw new IllegalStateException("there are no trials");
                }

                @Override
                public void cancel(long frame, int libraryId) {}
            };

    /** Returns whether a new version from a file of the laws folder needs a trial. */
    boolean areDue(LawLibrary library);

    /** Returns whether new parameters from a file of the laws folder need a trial. */
    boolean areDueForParameters();

    /**
     * Begins a trial of versions that take over together, in one frame. Ends running trials of
     * other versions of the same libraries. The implementation closes the versions.
     */
    void begin(long frame, List<NewVersion> versions);

    /**
     * Ends the trial of a new version of this library, if there is one. The loaded version stays.
     */
    void cancel(long frame, int libraryId);
}
