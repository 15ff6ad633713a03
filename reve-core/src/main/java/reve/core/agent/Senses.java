package reve.core.agent;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.TreeMap;
import java.util.function.Function;
import reve.core.world.ItemId;
import reve.core.world.Sensor;
import reve.core.world.WorldEvent;

/** What one agent perceives through its body's sensors, each at its own pace. The event loop's thread. */
final class Senses {

    /** The fields of events that name items. */
    private static final Set<String> ITEM_FIELDS = Set.of("item", "body", "actor", "target");
    private static final String FAULT = "fault";
    private static final String AGENT = "agent";

    private final ItemId body;
    private final List<Sensor> sensors;
    private final Map<String, Sample> samples = new HashMap<>();
    private View view = new View(0, 0, List.of());

    /** What a sensor last sensed. */
    private record Sample(Sensor sensor, long frame, List<Seen> items) {}

    /** @param sensors at least one */
    Senses(ItemId body, List<Sensor> sensors) {
        this.body = body;
        this.sensors = sensors;
    }

    /** What the agent perceives now: what each sensor senses, or sensed when it was its turn. */
    View look(Observatory world) {
        View all = world.everything();
        if (all.frame() == view.frame()) {
            return view;
        }
        var current = new ArrayList<Sample>(sensors.size());
        for (Sensor sensor : sensors) {
            Sample before = samples.get(sensor.name());
            boolean due = before == null || all.frame() < before.frame
                    || all.frame() - before.frame >= sensor.every();
            Sample now = due ? new Sample(sensor, all.frame(), world.sense(sensor, body)) : before;
            samples.put(sensor.name(), now);
            current.add(now);
        }
        view = new View(all.frame(), all.time(), merge(current));
        return view;
    }

    /** Of an item that several sensors sense, the newest is shown, with what all of them show. */
    private static List<Seen> merge(List<Sample> samples) {
        if (samples.size() == 1) {
            return samples.getFirst().items;
        }
        var newest = new TreeMap<ItemId, Sample>();
        var merged = new TreeMap<ItemId, Seen>();
        for (Sample sample : samples) {
            for (Seen seen : sample.items) {
                Sample other = newest.get(seen.id());
                boolean newer = other == null || sample.frame > other.frame;
                if (newer) {
                    newest.put(seen.id(), sample);
                }
                merged.merge(seen.id(), seen, (a, b) -> {
                    Seen shown = newer ? b : a;
                    return new Seen(shown.item(), shown.place(), a.shown().and(b.shown()), Map.of());
                });
            }
        }
        return List.copyOf(merged.values());
    }

    /**
     * What the agent hears of an event: nothing if it names items and the agent perceives none of them, else all
     * but the names of those it does not perceive. Faults are for operators.
     *
     * @param bodyOf the body's name of an agent, by its name
     */
    Optional<Map<String, Object>> hear(WorldEvent event, Observatory world,
            Function<String, Optional<String>> bodyOf) {
        if (event.type().equals(FAULT)) {
            return Optional.empty();
        }
        boolean namesItems = false;
        boolean perceivesOne = false;
        var heard = new LinkedHashMap<String, Object>();
        for (Map.Entry<String, Object> field : event.fields().entrySet()) {
            boolean isItem = ITEM_FIELDS.contains(field.getKey());
            boolean perceived = isItem ? perceives(world, field.getValue())
                    : !field.getKey().equals(AGENT) || perceivesAgent(event, world, bodyOf);
            namesItems |= isItem;
            perceivesOne |= isItem && perceived;
            if (perceived) {
                heard.put(field.getKey(), field.getValue());
            }
        }
        return namesItems && !perceivesOne ? Optional.empty() : Optional.of(heard);
    }

    private boolean perceivesAgent(WorldEvent event, Observatory world, Function<String, Optional<String>> bodyOf) {
        Object itsBody = event.fields().get("body");
        return itsBody != null ? perceives(world, itsBody)
                : bodyOf.apply(String.valueOf(event.fields().get(AGENT))).filter(name -> perceives(world, name))
                        .isPresent();
    }

    /** Something it senses now, or was told of and not yet that it has gone. */
    private boolean perceives(Observatory world, Object name) {
        return view.holds(String.valueOf(name)) || world.find(String.valueOf(name))
                .filter(item -> world.senses(sensors, body, item)).isPresent();
    }
}
