// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

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
import java.util.TreeMap;
import java.util.stream.Collectors;
import java.util.stream.Stream;

/**
 * What one agent perceives through its body's sensors, each at its own pace. The event loop's
 * thread.
 */
public final class Senses {

    /** Type of the event of a law that failed. */
    public static final String FAULT = "fault";

    private final ItemId body;
    private final List<Sensor> sensors;

    /** By sensor; all there once the agent has looked. */
    private final Sample[] samples;

    private final Surroundings[] surroundings;
    private View view = new View(0, 0, List.of());

    /** Relations of what was not sensed since. */
    private Map<ItemId, Map<String, List<String>>> related = Map.of();

    /** What a sensor last sensed. */
    private record Sample(long frame, List<PerceivedItem> items) {}

    /**
     * @param sensors at least one
     */
    public Senses(ItemId body, List<Sensor> sensors) {
        this.body = body;
        this.sensors = sensors;
        this.samples = new Sample[sensors.size()];
        this.surroundings =
                Stream.generate(Surroundings::new)
                        .limit(sensors.size())
                        .toArray(Surroundings[]::new);
    }

    /** Returns the id of the body. */
    public ItemId body() {
        return body;
    }

    /** The body's camera of that name. */
    public Optional<Sensor> camera(String name) {
        return sensors.stream()
                .filter(sensor -> sensor.isCamera() && sensor.name().equals(name))
                .findFirst();
    }

    /** What the agent perceives now: what each sensor senses, or sensed when it was its turn. */
    public View look(Observatory world) {
        View all = world.everything();
        if (all.frame() == view.frame()) {
            return view;
        }
        for (int i = 0; i < samples.length; i++) {
            Sample before = samples[i];
            Sensor sensor = sensors.get(i);
            if (before == null
                    || all.frame() < before.frame
                    || all.frame() - before.frame >= sensor.every()) {
                samples[i] =
                        new Sample(
                                all.frame(),
                                world.sense(
                                        sensor,
                                        body,
                                        surroundings[i],
                                        before == null ? List.of() : before.items));
            }
        }
        view = new View(all.frame(), all.time(), merge(samples));
        return view;
    }

    /**
     * What {@link #look} says, with the relations of each item as of when a sensor that tells
     * symbols sensed it last.
     *
     * @param all with the relations of now
     * @param fresh whose relations are of now
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
        return new View(all.frame(), all.time(), List.copyOf(items));
    }

    /**
     * Items whose symbols were sensed in the frame of the last {@link #look}.
     *
     * @return empty if every sensor senses in every frame
     */
    public Optional<Set<ItemId>> sensedIn(long frame) {
        if (sensors.stream().allMatch(sensor -> sensor.every() == 1)) {
            return Optional.empty();
        }
        var ids = new HashSet<ItemId>();
        for (Sample sample : samples) {
            if (sample.frame == frame) {
                sample.items.stream()
                        .filter(seen -> seen.shown().has(Sensor.Aspect.SEMANTIC))
                        .map(PerceivedItem::id)
                        .forEach(ids::add);
            }
        }
        return Optional.of(ids);
    }

    /** The relations that are known of an item, to what is still perceived. */
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

    /** By the items' ids. */
    private static List<PerceivedItem> merge(Sample[] samples) {
        if (samples.length == 1) {
            return samples[0].items;
        }
        Sample[] newestFirst = samples.clone();
        Arrays.sort(newestFirst, Comparator.comparingLong(Sample::frame).reversed());
        var merged = new TreeMap<ItemId, PerceivedItem>();
        for (Sample sample : newestFirst) {
            for (PerceivedItem seen : sample.items) {
                merged.merge(seen.id(), seen, Senses::merge);
            }
        }
        return List.copyOf(merged.values());
    }

    /**
     * What two sensors sense of an item. What the older one adds is as it was then: nobody is told
     * what no sensor of its own has sensed yet. What is symbolic is of one moment.
     */
    private static PerceivedItem merge(PerceivedItem newer, PerceivedItem older) {
        Visibility both = newer.shown().and(older.shown());
        if (both.equals(newer.shown())) {
            return newer;
        }
        boolean placed = newer.shown().has(Sensor.Aspect.PHYSICAL);
        return new PerceivedItem(
                newer.shown().isAllThatIsSymbolicOf(both) ? newer.item() : older.item(),
                placed ? newer.place() : older.place(),
                both,
                Map.of());
    }

    /**
     * Which fields of an event the agent is told, by their place: all but the names of those it
     * does not perceive. Empty if it hears nothing of it: it names items and the agent perceives
     * none of them, or is for operators.
     */
    public Optional<BitSet> hear(WorldEvent event, EventSubjects subjects, Observatory world) {
        if (event.type().equals(FAULT)) {
            return Optional.empty();
        }
        var told = new BitSet();
        boolean concerned = subjects.items().isEmpty();
        int place = 0;
        for (String field : event.fields().keySet()) {
            Mention mention = subjects.byField().get(field);
            boolean agent = field.equals(EventSubjects.AGENT);
            boolean tells = mention == null ? !agent : perceives(world, mention);
            concerned |= tells && mention != null && !agent;
            told.set(place++, tells);
        }
        return concerned ? Optional.of(told) : Optional.empty();
    }

    /** See {@link Observatory#reach}. */
    public boolean reach(Observatory world, double[] lows, double[] highs, int at) {
        return world.reach(sensors, body, lows, highs, at);
    }

    /** Something it senses now, or was told of and not yet that it has gone. */
    private boolean perceives(Observatory world, Mention mention) {
        if (mention.id().isEmpty()) {
            return view.holds(mention.name());
        }
        ItemId item = mention.id().get();
        return view.indexOf(item) >= 0 || world.senses(sensors, body, item);
    }
}
