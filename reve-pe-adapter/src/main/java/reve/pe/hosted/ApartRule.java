// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import java.nio.file.Path;
import java.util.Optional;

/**
 * The rule that decides which native law libraries run apart, that is, in a sandbox. A sandbox is a
 * process that can access only the columns that the library declares. For any thread.
 */
@FunctionalInterface
public interface ApartRule {
    /** The rule by which no library runs in a sandbox. */
    ApartRule NEVER = (file, library) -> Isolation.NONE;

    /** The ways to isolate a library from the engine and the other laws. */
    enum Isolation {
        /** Mode in which the library runs in the engine's process. */
        NONE,
        /**
         * Mode in which the library runs in a sandbox. The library is refused if the machine lacks
         * a layer of the sandbox.
         */
        APART,
        /** Mode in which the library runs in a sandbox with those layers that the machine has. */
        APART_WEAKLY
    }

    /**
     * Returns how a library is isolated. An engine calls this method once for each content of a
     * library, and keeps the result.
     *
     * @param file the library's file, if it was opened from one
     * @param library bytes of the library; the caller must not change them
     */
    Isolation of(Optional<Path> file, byte[] library);
}
