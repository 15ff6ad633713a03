// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import org.jspecify.annotations.Nullable;

import java.util.ArrayList;
import java.util.List;

/** A series of changes to the libraries of an engine, which can be undone. */
final class Changes {
    private final @Nullable HostProcess host;
    private final List<Loaded> before;
    private final List<Integer> intervals;
    private final KeptState.Saved state;
    private final List<Loaded> unloaded = new ArrayList<>();

    /**
     * @param host process in which the changes began; null if it was lost
     * @param before the libraries before the changes
     * @param state state of the engine before the changes
     */
    Changes(@Nullable HostProcess host, List<Loaded> before, KeptState.Saved state) {
        this.host = host;
        this.before = List.copyOf(before);
        this.intervals = before.stream().map(library -> library.interval).toList();
        this.state = state;
    }

    @Nullable HostProcess host() {
        return host;
    }

    KeptState.Saved state() {
        return state;
    }

    /**
     * Keeps an unloaded library, because the changes may be undone. Returns false if the library
     * was loaded after the beginning of the changes.
     */
    boolean setAside(Loaded library) {
        return before.contains(library) && unloaded.add(library);
    }

    /** Returns the unloaded libraries that were loaded at the beginning of the changes. */
    List<Loaded> unloaded() {
        return unloaded;
    }

    /**
     * Returns whether the host has more threads than it had before one of the unloaded libraries
     * was loaded.
     */
    boolean leftThreads(int threads) {
        return unloaded.stream().anyMatch(library -> threads > library.threads);
    }

    /**
     * Restores the list of libraries as it was at the beginning of the changes. Returns the
     * libraries that were loaded since then.
     */
    List<Loaded> restore(List<Loaded> libraries) {
        List<Loaded> added = new ArrayList<>(libraries);
        added.removeAll(before);
        libraries.clear();
        libraries.addAll(before);
        for (int i = 0; i < before.size(); i++) {
            before.get(i).interval = intervals.get(i);
        }
        return added;
    }
}
