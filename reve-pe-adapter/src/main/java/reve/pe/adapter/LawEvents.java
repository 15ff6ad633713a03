// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import org.jspecify.annotations.Nullable;

import reve.core.frame.TimeBudget;
import reve.core.world.RefusedSize;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.Status;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.regex.Pattern;
import java.util.stream.Collectors;

/**
 * The events that report changes and failures of the laws of a world. For the world's thread only.
 */
final class LawEvents {
    private static final Pattern NOT_FINITE = Pattern.compile("wrote -?(nan|inf|[0-9.]+e\\+)");

    private final World world;
    private final PhysicsEngine engine;

    /** The events of changes in progress, which may still be undone; null if there are none. */
    private @Nullable List<WorldEvent> held;

    LawEvents(World world, PhysicsEngine engine) {
        this.world = world;
        this.engine = engine;
    }

    /** Holds events back until {@link #release} or {@link #drop}. */
    void hold() {
        held = new ArrayList<>();
    }

    /** Raises the events that were held back. */
    void release() {
        List<WorldEvent> ready = held == null ? List.of() : held;
        held = null;
        ready.forEach(world::raise);
    }

    /** Drops the events that were held back. */
    void drop() {
        held = null;
    }

    private void raise(WorldEvent event) {
        if (held == null) {
            world.raise(event);
        } else {
            held.add(event);
        }
    }

    /** Reports that a library was unloaded. */
    void unloaded(long frame, Map<String, Object> fields) {
        raise(new WorldEvent(frame, "law-unloaded", fields));
    }

    /** Reports that a library was loaded. */
    void loaded(long frame, LawLibrary library, int libraryId) {
        Map<String, Object> fields = fields(library);
        fields.put(
                "laws",
                engine.laws(libraryId).stream()
                        .map(PhysicsLaw::name)
                        .collect(Collectors.joining(", ")));
        raise(new WorldEvent(frame, "law-loaded", fields));
    }

    /**
     * Reports that a library exceeded its budget.
     *
     * @param nanoseconds time of the library in the last frame [ns]
     * @param done end of the message, which states the consequence for the library
     */
    void overBudget(
            long frame, LawLibrary library, TimeBudget budget, long nanoseconds, String done) {
        Map<String, Object> fields = fields(library);
        fields.put("milliseconds", nanoseconds / 1e6);
        budget.fields()
                .forEach(
                        (name, value) ->
                                fields.put(
                                        name.equals("milliseconds") ? "budgetMilliseconds" : name,
                                        value));
        fields.put(
                "message",
                String.format(
                        Locale.ROOT,
                        "library %s exceeded its budget of %.3g ms in %d frames in a row, with %.3g"
                                + " ms in the last one%s",
                        library.name(),
                        budget.milliseconds(),
                        budget.frames(),
                        nanoseconds / 1e6,
                        done));
        raise(new WorldEvent(frame, "over-budget", fields));
    }

    /** Reports that the engine refused a call or a law failed. */
    void fault(long frame, Map<String, Object> fields, PhysicsException failure) {
        fields.put("status", failure.status().name());
        fields.put("message", failure.getMessage() + remedy(fields, failure));
        raise(new WorldEvent(frame, "fault", fields));
    }

    /**
     * Reports that laws wrote a size that a body's shape cannot have, so that the body keeps its
     * shape.
     *
     * @param names names of the laws that write sizes
     */
    void refusedSize(long frame, String names, RefusedSize refused) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("source", "physics");
        fields.put("law", names);
        fields.put("property", PropertyNames.SIZE);
        fields.put("item", refused.item().name());
        fields.put("status", Status.LAW_MISBEHAVED.name());
        fields.put(
                "message",
                "law "
                        + names
                        + ": property "
                        + PropertyNames.SIZE
                        + " of item "
                        + refused.item().name()
                        + ": wrote "
                        + refused.size()
                        + " m, expected lengths from 1e-100 m to 1e12 m, so the item keeps its"
                        + " shape; give the law a smallest and a largest size (reported once; other"
                        + " items may have the same problem)");
        raise(new WorldEvent(frame, "fault", fields));
    }

    /**
     * Returns the end of the message about a fault with numbers that are not finite. It names the
     * item and says what to do. Returns an empty text for other faults.
     */
    private static String remedy(Map<String, Object> fields, PhysicsException failure) {
        return failure.status() == Status.LAW_MISBEHAVED
                        && NOT_FINITE.matcher(String.valueOf(failure.getMessage())).find()
                ? (fields.containsKey("item") ? " of item " + fields.get("item") : "")
                        + "; if the world has diverged, make its steps shorter (frame: steps in the"
                        + " world file), or its springs and contacts softer: ./reve check names"
                        + " those that are too stiff"
                : "";
    }

    /** Adds the place at which a law failed. */
    static void addPlace(Map<String, Object> fields, PhysicsException failure) {
        fields.put("law", failure.law());
        fields.put("property", failure.property());
        failure.row().ifPresent(row -> fields.put("row", row));
    }

    /**
     * Returns the fields of an event about a library, with the calls and times of its laws. Called
     * before the library is unloaded, because the engine then discards these numbers.
     */
    Map<String, Object> fieldsWithCost(LawLibrary library, int libraryId) {
        Map<String, Object> fields = fields(library);
        long calls = 0;
        long nanoseconds = 0;
        for (PhysicsLaw law : engine.laws(libraryId)) {
            calls += law.calls();
            nanoseconds += law.nanoseconds();
        }
        fields.put("calls", calls);
        fields.put("milliseconds", nanoseconds / 1e6);
        return fields;
    }

    /** Returns the fields of an event about a library. */
    static Map<String, Object> fields(LawLibrary library) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("source", "physics");
        fields.put("library", library.name());
        fields.put("sha256", library.sha256());
        return fields;
    }
}
