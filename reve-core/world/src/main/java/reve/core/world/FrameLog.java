// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.ArrayList;
import java.util.Collections;
import java.util.List;

/**
 * A list of events or changes of one frame. The phase PUBLISH fixes it, so that all readers see the
 * same entries; the end of the frame clears it. World's thread only.
 */
final class FrameLog<T> {

    private final int limit;
    private List<T> noted = new ArrayList<>();
    private @Nullable List<T> published;
    private long lost;
    private long publishedLost;

    /**
     * @param limit maximum number of entries per frame; further ones are only counted
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
     * Returns the entries of this frame in the order of addition: the fixed list, or a copy before
     * {@link #fix()}.
     */
    List<T> entries() {
        return published != null ? published : List.copyOf(noted);
    }

    /** Returns how many entries of this frame were not stored because of the limit. */
    long lost() {
        return published != null ? publishedLost : lost;
    }

    /**
     * Makes the entries of this frame final; further ones belong to the next frame. Allocates
     * memory only if there are entries.
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

    /** Discards the entries of this frame, fixed or not. */
    void end() {
        if (published == null) {
            noted.clear();
            lost = 0;
        }
        published = null;
    }
}
