// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import org.jspecify.annotations.Nullable;

import reve.core.agent.perception.SensedWorld;
import reve.core.world.ActionRefused;
import reve.core.world.EventBudget;
import reve.core.world.Item;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.SortedMap;

/**
 * The speech of agents: checks the texts that they say, and computes the parts that other agents
 * hear. Speech changes nothing in the world. For the world's thread only.
 */
final class Speech {

    /** Name of the capability that a token must permit so that its agent may speak. */
    private static final String SPEAK = "speak";

    /**
     * Number of evaluation steps that an utterance costs its speaker for each agent that hears it.
     * The server encodes and sends an event for each of them. The number limits these events to
     * some hundreds in a frame, so that agents of other worlds receive their perceptions.
     */
    static final int OF_HEARER = 400;

    /**
     * Maximum number of bodies that the lines of sight of all hearers to one speaker may pass. The
     * hearers that are left hear an unnamed voice. Each body costs the speaker one step.
     */
    static final int MOST_PASSED = 20_000;

    private final EventBudget events;
    private final SensedWorld sensed = new SensedWorld();
    private final AllBodies allBodies = new AllBodies();
    private final List<Heard> heard = new ArrayList<>();

    /**
     * @param events limit on the events of agents; each utterance counts as events
     */
    Speech(EventBudget events) {
        this.events = events;
    }

    /**
     * Says a text, and computes the part that each other agent hears.
     *
     * @param speaker body of the agent; it has a voice and a place
     * @param arguments arguments of the act, not checked yet
     * @param bodies the bodies of all agents, by agent
     * @return the number of evaluation steps that the utterance cost
     * @throws ActionRefused if the arguments are wrong, the agent's token does not permit speech,
     *     or the budget of events is spent; nothing is said then
     */
    long say(
            World world,
            long frame,
            String agent,
            Item speaker,
            Map<String, ?> arguments,
            SortedMap<String, Body> bodies)
            throws ActionRefused {
        String text = Utterance.textIn(arguments);
        if (!bodies.get(agent).rights().opensCapability(SPEAK)) {
            throw new ActionRefused(
                    "not-capable",
                    "action say of "
                            + speaker.name()
                            + " needs the capability `speak`, which this agent's token does not"
                            + " permit");
        }
        var fields = new LinkedHashMap<String, Object>();
        fields.put("agent", agent);
        fields.put("body", speaker.name());
        fields.put("text", text);
        var spoke = new WorldEvent(frame, "spoke", fields);
        events.require(agent, frame, spoke.bytes());
        events.take(agent, frame, spoke.bytes());
        world.raise(spoke);
        return tellHearers(
                world,
                frame,
                speaker,
                new Utterance(
                        world.name(),
                        frame,
                        speaker.id(),
                        speaker.physical().location(),
                        speaker.voice().orElseThrow(),
                        text),
                bodies);
    }

    private long tellHearers(
            World world,
            long frame,
            Item speaker,
            Utterance utterance,
            SortedMap<String, Body> bodies) {
        Table table = world.table(WorldPrototype.BODY);
        int row = table.rowOf(speaker.id());
        long cost = bodies.size();
        long passed = 0;
        for (Map.Entry<String, Body> other : bodies.entrySet()) {
            Body hearer = other.getValue();
            Optional<Item> item = hearer.in(world).filter(found -> !found.physical().isEmpty());
            if (item.isEmpty() || hearer.id().equals(speaker.id())) {
                continue;
            }
            double[] at = item.get().physical().location();
            boolean perceivesAll = hearer.sensors().isEmpty();
            Optional<Utterance.Arrived> arrived =
                    perceivesAll
                            ? Optional.of(utterance.whole())
                            : utterance.at(hearer.id(), hearer.ears(), utterance.distance(at));
            if (arrived.isEmpty()) {
                continue;
            }
            boolean isKnown = perceivesAll;
            if (!perceivesAll && hearer.needsSight()) {
                cost += allBodies.load(world, frame);
                if (passed < MOST_PASSED) {
                    long before = allBodies.sensed.visited();
                    isKnown = senses(allBodies.sensed, hearer, table, row);
                    passed += allBodies.sensed.visited() - before;
                }
            } else if (!perceivesAll) {
                sensed.load(table, table.rowOf(hearer.id()), row);
                isKnown = senses(sensed, hearer, table, row);
            }
            heard.add(
                    new Heard(
                            other.getKey(),
                            utterance.event(
                                    arrived.get(),
                                    isKnown ? Optional.of(speaker.name()) : Optional.empty(),
                                    at)));
            cost += OF_HEARER;
        }
        return cost + passed;
    }

    private static boolean senses(SensedWorld sensed, Body hearer, Table table, int row) {
        return Body.senses(sensed, hearer.sensors(), table.rowOf(hearer.id()), row);
    }

    /** All bodies of a world, which are loaded again only if they may have moved. */
    private static final class AllBodies {
        private static final List<String> COLUMNS = List.of("position", "orientation", "shape");

        private final SensedWorld sensed = new SensedWorld();
        private @Nullable World of;
        private List<Long> loaded = List.of();

        /** Loads the bodies; returns the steps that this costs. */
        private int load(World world, long frame) {
            Table table = world.table(WorldPrototype.BODY);
            var state = new ArrayList<>(List.of(frame, world.layoutVersion()));
            COLUMNS.forEach(column -> state.add(table.column(column).version()));
            if (world == of && state.equals(loaded)) {
                return 0;
            }
            of = world;
            loaded = state;
            sensed.load(table);
            return table.rowCount();
        }
    }

    /**
     * Returns the utterances that agents have heard since the last call, in the order in which they
     * were said. The entries of one utterance are in the order of the hearers' names.
     */
    List<Heard> takeHeard() {
        if (heard.isEmpty()) {
            return List.of();
        }
        List<Heard> taken = List.copyOf(heard);
        heard.clear();
        return taken;
    }
}
