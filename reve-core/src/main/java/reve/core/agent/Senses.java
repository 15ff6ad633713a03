package reve.core.agent;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.TreeMap;
import reve.core.agent.Mentions.Mention;
import reve.core.world.ItemId;
import reve.core.world.Sensor;
import reve.core.world.WorldEvent;

/** What one agent perceives through its body's sensors, each at its own pace. The event loop's thread. */
final class Senses {

    private static final String FAULT = "fault";

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

    ItemId body() {
        return body;
    }

    /** The body's camera of that name. */
    Optional<Sensor> camera(String name) {
        return sensors.stream().filter(sensor -> sensor.isCamera() && sensor.name().equals(name)).findFirst();
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
     */
    Optional<Map<String, Object>> hear(WorldEvent event, Mentions mentions, Observatory world) {
        if (event.type().equals(FAULT) || mentions.namesItems() && !perceivesAny(mentions, world)) {
            return Optional.empty();
        }
        var heard = new LinkedHashMap<String, Object>();
        event.fields().forEach((field, value) -> {
            Mention mention = mentions.byField().get(field);
            if (mention == null ? !field.equals(Mentions.AGENT) : perceives(world, mention)) {
                heard.put(field, value);
            }
        });
        return Optional.of(heard);
    }

    private boolean perceivesAny(Mentions mentions, Observatory world) {
        for (Map.Entry<String, Mention> mention : mentions.byField().entrySet()) {
            if (!mention.getKey().equals(Mentions.AGENT) && perceives(world, mention.getValue())) {
                return true;
            }
        }
        return false;
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
