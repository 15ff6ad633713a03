// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.frame.FrameEvent;
import reve.core.frame.FrameListener;
import reve.core.world.WorldEvent;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Set;

/**
 * Counter of a run's events and list of its faults, for the report. For the world's thread only.
 */
public final class RunEvents implements FrameListener {
    private static final int MAX_FAULTS = 100;

    private final Map<String, Long> counts = new LinkedHashMap<>();
    private final Set<String> libraries = new LinkedHashSet<>();
    private final List<WorldEvent> faults = new ArrayList<>();

    @Override
    public void onFrame(FrameEvent frame) {
        for (WorldEvent event : frame.world().events()) {
            counts.merge(event.type(), 1L, Long::sum);
            if (event.type().equals("law-loaded")) {
                libraries.add((String) event.fields().get("library"));
            }
            if (event.type().equals("fault") && faults.size() < MAX_FAULTS) {
                faults.add(event);
            }
        }
    }

    /** Returns the number of events of a type. */
    public long count(String type) {
        return counts.getOrDefault(type, 0L);
    }

    /** Returns the names of all law libraries that were loaded at any time, in order of loading. */
    public List<String> libraries() {
        return List.copyOf(libraries);
    }

    /** Returns the first hundred faults, in order. */
    public List<WorldEvent> faults() {
        return List.copyOf(faults);
    }
}
