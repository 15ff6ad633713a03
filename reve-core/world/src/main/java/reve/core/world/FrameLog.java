// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.ArrayList;
import java.util.Collections;
import java.util.List;

/**
 * What was noted while a frame is made: a list that PUBLISH shows to everybody as it then is, and
 * that the frame's end forgets. World's thread only.
 */
final class FrameLog<T> {

    private final int limit;
    private List<T> noted = new ArrayList<>();
    private @Nullable List<T> published;
    private long lost;
    private long publishedLost;

    /**
     * @param limit how many entries a frame keeps; later ones are only counted
     */
    FrameLog(int limit) {
        this.limit = limit;
    }

    /** Adds to the frame that is being made, or to the next one after {@link #fix()}. */
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

    /** Entries of this frame in the order noted; a copy unless fixed. */
    List<T> entries() {
        return published != null ? published : List.copyOf(noted);
    }

    /** How many entries of this frame did not fit. */
    long lost() {
        return published != null ? publishedLost : lost;
    }

    /** What is added from now on belongs to the next frame. Allocates only if there are entries. */
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

    /** Forgets this frame, fixed or not. */
    void end() {
        if (published == null) {
            noted.clear();
            lost = 0;
        }
        published = null;
    }
}
