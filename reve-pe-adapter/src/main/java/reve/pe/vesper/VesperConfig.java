// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import java.nio.file.Path;
import java.util.List;

/**
 * The configuration of a Vesper engine.
 *
 * @param threads maximum number of threads on which laws compute, including the caller's; at least
 *     1. Results do not depend on this number
 * @param validate whether laws run on guarded copies and their accesses are checked, which takes
 *     more time
 * @param lawPath folders searched for bare law names, in this order; their names contain no ':'
 * @param log receives the log lines of engine and laws
 */
public record VesperConfig(int threads, boolean validate, List<Path> lawPath, VesperLog log) {
    /** Copies the list. Refuses fewer than one thread, and folders whose names contain ':'. */
    public VesperConfig {
        if (threads < 1) {
            throw new IllegalArgumentException("threads is " + threads + ", expected at least 1");
        }
        lawPath = List.copyOf(lawPath);
        for (Path folder : lawPath) {
            if (folder.toString().contains(":")) {
                throw new IllegalArgumentException(
                        "law folder '"
                                + folder
                                + "' has a ':' in its name, which separates folders; rename it");
            }
        }
    }

    /** Returns a configuration with one thread, without validation, and without a log. */
    public static VesperConfig of(List<Path> lawPath) {
        return new VesperConfig(1, false, lawPath, (level, message) -> {});
    }
}
