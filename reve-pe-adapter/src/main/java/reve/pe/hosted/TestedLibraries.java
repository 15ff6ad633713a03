// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;

/**
 * The libraries that have passed a {@link Trial}, so that equal bytes are not tested again: a
 * change of a parameter or a rewind loads a library again, and must not depend on another process.
 * For any thread.
 */
final class TestedLibraries {

    /** Maximum number of libraries that are remembered, those that were tested last. */
    private static final int MOST = 256;

    private final Map<String, String> names =
            new LinkedHashMap<>() {
                private static final long serialVersionUID = 1;

                @Override
                protected boolean removeEldestEntry(Map.Entry<String, String> eldest) {
                    return size() > MOST;
                }
            };

    synchronized void add(HostedLibrary library) {
        names.put(library.identity(), library.name());
    }

    /** Returns the library's own name, if these bytes have passed a trial. */
    synchronized Optional<String> name(HostedLibrary library) {
        return Optional.ofNullable(names.get(library.identity()));
    }
}
