// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import java.nio.file.Path;

/**
 * Where and how a run is recorded.
 *
 * @param file a recording that is there already becomes {@code FILE.1}
 * @param maxBytes size at which the recording ends [bytes]
 * @param keep older recordings {@code FILE.1} to {@code FILE.keep} that are kept
 */
public record RecordingPlan(Path file, long maxBytes, int keep) {

    public static final int DEFAULT_KEEP = 8;

    /**
     * @throws IllegalArgumentException if the size is less than 1 byte or no file is kept
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

    /** No limit of the size, and the default number of older recordings. */
    public static RecordingPlan of(Path file) {
        return new RecordingPlan(file, Long.MAX_VALUE, DEFAULT_KEEP);
    }
}
