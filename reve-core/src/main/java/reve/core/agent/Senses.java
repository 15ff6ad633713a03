package reve.core.agent;

import java.util.BitSet;
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

    static final String FAULT = "fault";

    private final ItemId body;
    private final List<Sensor> sensors;
    /** By sensor; all there once the agent has looked. */
    private final Sample[] samples;
    private View view = new View(0, 0, List.of());

    /** What a sensor last sensed. */
    private record Sample(long frame, List<Seen> items) {}

    /** @param sensors at least one */
    Senses(ItemId body, List<Sensor> sensors) {
        this.body = body;
        this.sensors = sensors;
        this.samples = new Sample[sensors.size()];
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
        for (int i = 0; i < samples.length; i++) {
            Sample before = samples[i];
            Sensor sensor = sensors.get(i);
            if (before == null || all.frame() < before.frame || all.frame() - before.frame >= sensor.every()) {
                samples[i] = new Sample(all.frame(),
                        world.sense(sensor, body, before == null ? List.of() : before.items));
            }
        }
        view = new View(all.frame(), all.time(), merge(samples));
        return view;
    }

    /** Of an item that several sensors sense, the newest is shown, with what all of them show. */
    private static List<Seen> merge(Sample[] samples) {
        if (samples.length == 1) {
            return samples[0].items;
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
     * Which fields of an event the agent is told, by their place: all but the names of those it does not perceive.
     * Empty if it hears nothing of it: it names items and the agent perceives none of them, or is for operators.
     */
    Optional<BitSet> hear(WorldEvent event, Mentions mentions, Observatory world) {
        if (event.type().equals(FAULT)) {
            return Optional.empty();
        }
        var told = new BitSet();
        boolean concerned = mentions.items().isEmpty();
        int place = 0;
        for (String field : event.fields().keySet()) {
            Mention mention = mentions.byField().get(field);
            boolean agent = field.equals(Mentions.AGENT);
            boolean tells = mention == null ? !agent : perceives(world, mention);
            concerned |= tells && mention != null && !agent;
            told.set(place++, tells);
        }
        return concerned ? Optional.of(told) : Optional.empty();
    }

    /** See {@link Observatory#reach}. */
    boolean reach(Observatory world, double[] lows, double[] highs, int at) {
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
