// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.ArrayList;
import java.util.Collections;
import java.util.List;

/**
 * A list of events or changes of one frame. The phase PUBLISH makes the list final, so that all
 * readers see the same entries. The end of the frame clears the list. For the world's thread only.
 */
final class FrameLog<T> {

    private final int limit;
    private List<T> noted = new ArrayList<>();
    private @Nullable List<T> published;
    private long lost;
    private long publishedLost;

    /**
     * @param limit maximum number of entries per frame. Further entries are counted, but not stored
     */
    FrameLog(int limit) {
        this.limit = limit;
    }

    /** Adds an entry to the frame that is being made or, after {@link #fix()}, to the next one. */
    void add(T entry) {
        if (noted.size() < limit) {
            noted.add(entry);
        } else {
            lost++;
        }
    }

    boolean isFixed() {
        return published != null;
    }

    /**
     * Returns the entries of this frame in the order of addition. The result is a copy before
     * {@link #fix()}, and the final list after it.
     */
    List<T> entries() {
        return published != null ? published : List.copyOf(noted);
    }

    /** Returns how many entries of this frame were not stored because of the limit. */
    long lost() {
        return published != null ? publishedLost : lost;
    }

    /**
     * Makes the entries of this frame final. Entries that are added later belong to the next frame.
     * Allocates memory only if there are entries.
     */
    void fix() {
        publishedLost = lost;
        lost = 0;
        if (noted.isEmpty()) {
            published = List.of();
        } else {
            published = Collections.unmodifiableList(noted);
            noted = new ArrayList<>();
        }
    }

    /** Discards the entries of this frame, whether {@link #fix()} was called or not. */
    void end() {
        if (published == null) {
            noted.clear();
            lost = 0;
        }
        published = null;
    }
}
