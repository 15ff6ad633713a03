// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import java.nio.file.Path;

/**
 * The file and the limits of a recording.
 *
 * @param file an existing recording is renamed to {@code FILE.1}
 * @param maxBytes size at which the recording ends [bytes]
 * @param keep number of older recordings that are kept, {@code FILE.1} to {@code FILE.keep}
 */
public record RecordingPlan(Path file, long maxBytes, int keep) {

    public static final int DEFAULT_KEEP = 8;

    /**
     * Checks the size and the number of files.
     *
     * @throws IllegalArgumentException if the size is less than 1 byte, or {@code keep} less than 1
     */
    public RecordingPlan {
        if (maxBytes < 1 || keep < 1) {
            throw new IllegalArgumentException(
                    "a recording of "
                            + maxBytes
                            + " bytes and "
                            + keep
                            + " older files, expected 1 or more of each");
        }
    }

    /** Returns a plan without a size limit and with the default number of older recordings. */
    public static RecordingPlan of(Path file) {
        return new RecordingPlan(file, Long.MAX_VALUE, DEFAULT_KEEP);
    }
}
