// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;

/**
 * The libraries that have passed a {@link Trial}, so that equal bytes are not tested again. A
 * change of a parameter and a rewind load a library again. They must not depend on the process of a
 * further trial. For any thread.
 */
final class TestedLibraries {

    /** Maximum number of libraries in this cache; it contains those that were tested last. */
    private static final int MOST = 256;

    private final Map<String, Declared> tested =
            new LinkedHashMap<>() {
                private static final long serialVersionUID = 1;

                @Override
                protected boolean removeEldestEntry(Map.Entry<String, Declared> eldest) {
                    return size() > MOST;
                }
            };

    synchronized void add(HostedLibrary library) {
        tested.put(library.identity(), new Declared(library.name(), library.versions()));
    }

    /** Returns the declarations of the library in its trial, if these bytes have passed a trial. */
    synchronized Optional<Declared> find(HostedLibrary library) {
        return Optional.ofNullable(tested.get(library.identity()));
    }

    /** The library's own name, and the versions of the programs that it uses. */
    record Declared(String name, String versions) {}
}
