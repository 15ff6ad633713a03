// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import org.jspecify.annotations.Nullable;

import reve.core.agent.perception.EventSubjects.Mention;
import reve.core.world.ItemId;
import reve.core.world.Sensor;
import reve.core.world.WorldEvent;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.BitSet;
import java.util.Comparator;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.BooleanSupplier;
import java.util.stream.Collectors;

/**
 * The perceptions of one agent through its body's sensors, each with its own interval. For the
 * event loop's thread.
 */
public final class Senses {

    /**
     * Types of the events that are sent to operators only. These events report a failed law,
     * listener or command, or the results of a new version of a law that runs in the shadow.
     */
    public static final Set<String> FOR_OPERATORS = Set.of("fault", "law-shadow");

    private final ItemId body;
    private final List<Sensor> sensors;

    /**
     * The last perception of each sensor. All elements are present after the agent's first view.
     */
    private final Sample[] samples;

    private final Surroundings[] surroundings;
    private final Scan[] scans;
    private final boolean hasInstruments;
    private final boolean needsSight;

    /**
     * The copy of the world in which {@link #surroundings} were found; null before the first
     * search.
     */
    private @Nullable Observatory lastWorld;

    private View view = new View(0, 0, List.of());

    /**
     * The relations that were last sent, by item. They are kept for items that no sensor senses in
     * the current frame.
     */
    private Map<ItemId, Map<String, List<String>>> related = Map.of();

    /**
     * The items that a sensor perceived, and the frame in which it perceived them.
     *
     * @param sensed the items
     * @param reading measured numbers; empty unless the sensor is an instrument
     */
    private record Sample(long frame, Weighed sensed, List<Reading> reading) {
        /** Returns the items as this agent perceives them. */
        List<PerceivedItem> items() {
            return sensed.items();
        }
    }

    /**
     * @param sensors the sensors of the body, at least one
     */
    public Senses(ItemId body, List<Sensor> sensors) {
        this.body = body;
        this.sensors = sensors;
        this.samples = new Sample[sensors.size()];
        this.surroundings = new Surroundings[sensors.size()];
        this.scans = new Scan[sensors.size()];
        this.hasInstruments = sensors.stream().anyMatch(one -> one.instrument().isPresent());
        this.needsSight = sensors.stream().anyMatch(Sensor::lineOfSight);
    }

    /** Returns the id of the body. */
    public ItemId body() {
        return body;
    }

    /** Returns the body's sensors. */
    public List<Sensor> sensors() {
        return sensors;
    }

    /** Returns whether one of the sensors needs a line of sight. */
    public boolean needsSight() {
        return needsSight;
    }

    /** Returns the body's camera of that name. */
    public Optional<Sensor> camera(String name) {
        return sensors.stream()
                .filter(sensor -> sensor.isCamera() && sensor.name().equals(name))
                .findFirst();
    }

    /** Returns the last view; its frame is 0 if there was none. */
    public View lastView() {
        return view;
    }

    /** Returns the present view. The computation has no time limit. */
    View look(Observatory world) {
        return look(world, () -> true).orElseThrow();
    }

    /**
     * Returns the view of the newest frame. Each sensor perceives again if its interval has passed.
     * The last perceptions of all sensors are then merged.
     *
     * @param isTimeLeft false if the caller must do other work first
     * @return empty if the time was too short; the next call in this frame continues
     */
    public Optional<View> look(Observatory world, BooleanSupplier isTimeLeft) {
        View all = world.everything();
        if (all.frame() == view.frame()) {
            return Optional.of(view);
        }
        if (world != lastWorld) {
            Arrays.setAll(surroundings, unknown -> new Surroundings());
            Arrays.setAll(scans, unknown -> new Scan());
            lastWorld = world;
        }
        for (int i = 0; i < samples.length; i++) {
            Sample before = samples[i];
            Sensor sensor = sensors.get(i);
            if (before == null
                    || all.frame() < before.frame
                    || all.frame() - before.frame >= sensor.every()) {
                Optional<List<PerceivedItem>> sensed =
                        world.sense(
                                sensor,
                                body,
                                surroundings[i],
                                before == null ? List.of() : before.sensed.from(),
                                isTimeLeft);
                if (sensed.isEmpty()) {
                    return Optional.empty();
                }
                Optional<List<Reading>> reading =
                        sensor.instrument().isEmpty()
                                ? Optional.of(List.of())
                                : world.measure(sensor, body, scans[i], isTimeLeft);
                if (reading.isEmpty()) {
                    return Optional.empty();
                }
                samples[i] =
                        new Sample(
                                all.frame(),
                                world.weigh(
                                        body,
                                        sensed.get(),
                                        before == null ? Weighed.NOTHING : before.sensed),
                                reading.get());
            }
        }
        view = new View(all.frame(), all.time(), merge(samples), readings());
        return Optional.of(view);
    }

    /**
     * Adds relations to the view of {@link #look}. Each item has the relations from the time when a
     * sensor for symbols last sensed it.
     *
     * @param all the view with the relations of its frame
     * @param fresh ids of the items that get these relations; the other items keep older ones
     */
    public View relate(View all, Set<ItemId> fresh) {
        var names = all.items().stream().map(PerceivedItem::name).collect(Collectors.toSet());
        var items = new ArrayList<PerceivedItem>();
        var known = new HashMap<ItemId, Map<String, List<String>>>();
        for (PerceivedItem seen : all.items()) {
            PerceivedItem told =
                    fresh.contains(seen.id()) ? seen : seen.with(among(names, seen.id()));
            items.add(told);
            known.put(told.id(), told.relations());
        }
        related = known;
        return new View(all.frame(), all.time(), List.copyOf(items), all.readings());
    }

    /** Returns the newest readings in the order of the sensors. */
    private List<Reading> readings() {
        if (!hasInstruments) {
            return List.of();
        }
        var all = new ArrayList<Reading>();
        for (Sample sample : samples) {
            all.addAll(sample.reading);
        }
        return List.copyOf(all);
    }

    /**
     * Returns the items whose symbols were sensed in a frame.
     *
     * @param frame the frame of the last call of {@link #look}
     * @return ids; an empty Optional if every sensor senses in every frame
     */
    public Optional<Set<ItemId>> sensedIn(long frame) {
        if (sensors.stream().allMatch(sensor -> sensor.every() == 1)) {
            return Optional.empty();
        }
        var ids = new HashSet<ItemId>();
        for (Sample sample : samples) {
            if (sample.frame == frame) {
                sample.items().stream()
                        .filter(seen -> seen.shown().has(Sensor.Aspect.SEMANTIC))
                        .map(PerceivedItem::id)
                        .forEach(ids::add);
            }
        }
        return Optional.of(ids);
    }

    /** Returns the known relations of an item, restricted to items that are still perceived. */
    private Map<String, List<String>> among(Set<String> names, ItemId item) {
        var relations = new LinkedHashMap<String, List<String>>();
        related.getOrDefault(item, Map.of())
                .forEach(
                        (relation, others) ->
                                relations.put(
                                        relation,
                                        others.stream().filter(names::contains).toList()));
        return relations;
    }

    /** Merges the samples in the order of ids. */
    private static List<PerceivedItem> merge(Sample[] samples) {
        if (samples.length == 1) {
            return samples[0].items();
        }
        Sample[] newestFirst = samples.clone();
        Arrays.sort(newestFirst, Comparator.comparingLong(Sample::frame).reversed());
        List<PerceivedItem> merged = newestFirst[0].items();
        for (int i = 1; i < newestFirst.length; i++) {
            merged = merge(merged, newestFirst[i].items());
        }
        return List.copyOf(merged);
    }

    /** Merges two lists in the order of ids. */
    private static List<PerceivedItem> merge(List<PerceivedItem> newer, List<PerceivedItem> older) {
        var merged = new ArrayList<PerceivedItem>(Math.max(newer.size(), older.size()));
        int i = 0;
        for (PerceivedItem seen : older) {
            while (i < newer.size() && newer.get(i).id().compareTo(seen.id()) < 0) {
                merged.add(newer.get(i++));
            }
            boolean isInBoth = i < newer.size() && newer.get(i).id().equals(seen.id());
            merged.add(isInBoth ? merge(newer.get(i++), seen) : seen);
        }
        merged.addAll(newer.subList(i, newer.size()));
        return merged;
    }

    /**
     * Merges two sensors' perceptions of an item. Data that only the older perception contains is
     * kept, because no sensor has sensed a newer value. All symbols come from one of the two
     * perceptions.
     */
    private static PerceivedItem merge(PerceivedItem newer, PerceivedItem older) {
        Visibility both = newer.shown().and(older.shown());
        if (both.equals(newer.shown())) {
            return newer;
        }
        PerceivedItem placed = newer.shown().has(Sensor.Aspect.PHYSICAL) ? newer : older;
        PerceivedItem symbolic = newer.shown().isAllThatIsSymbolicOf(both) ? newer : older;
        return new PerceivedItem(symbolic.item(), placed.place(), both, symbolic.isTooHeavy());
    }

    /**
     * Returns the indices of the event's fields that are sent to the agent. Names of items that the
     * agent does not perceive are not sent. The result is empty if the event itself is not sent.
     * The reason is that the agent perceives none of the event's items, or that the event is for
     * operators only.
     *
     * @param searches false if only the last view decides what the agent perceives, because there
     *     is no time to search for items that it senses now
     */
    public Optional<BitSet> hear(
            WorldEvent event, EventSubjects subjects, Observatory world, boolean searches) {
        if (FOR_OPERATORS.contains(event.type())) {
            return Optional.empty();
        }
        var told = new BitSet();
        boolean concerned = subjects.items().isEmpty();
        int place = 0;
        for (String field : event.fields().keySet()) {
            Mention mention = subjects.byField().get(field);
            boolean agent = field.equals(EventSubjects.AGENT);
            boolean tells = mention == null ? !agent : perceives(world, mention, searches);
            concerned |= tells && mention != null && !agent;
            told.set(place++, tells);
        }
        return concerned ? Optional.of(told) : Optional.empty();
    }

    /**
     * Computes a box that contains everything the sensors can reach. See {@link Observatory#reach}.
     */
    public boolean reach(Observatory world, double[] lows, double[] highs, int at) {
        return world.reach(sensors, body, lows, highs, at);
    }

    /** Returns whether the agent senses the item now, or its last view contains the item. */
    private boolean perceives(Observatory world, Mention mention, boolean searches) {
        if (mention.id().isEmpty()) {
            return view.holds(mention.name());
        }
        ItemId item = mention.id().get();
        return view.indexOf(item) >= 0 || searches && world.senses(sensors, body, item);
    }
}
