// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

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
 * The speech of agents: checks what they say, and computes what other agents hear. It changes
 * nothing in the world. For the world's thread only.
 */
final class Speech {

    /** Name of the capability that a token must permit so that its agent may speak. */
    private static final String SPEAK = "speak";

    /** Steps that an utterance costs its speaker for each agent that hears it. */
    private static final int OF_HEARER = 40;

    private final EventBudget events;
    private final SensedWorld sensed = new SensedWorld();
    private final List<Heard> heard = new ArrayList<>();

    /**
     * @param events limit on the events of agents, to which each utterance counts
     */
    Speech(EventBudget events) {
        this.events = events;
    }

    /**
     * Says a text, and computes what each other agent hears of it.
     *
     * @param speaker body of the agent; it has a voice and a place
     * @param arguments arguments of the act, not checked yet
     * @param bodies the bodies of all agents, by agent
     * @return the steps that this cost
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
            World world, Item speaker, Utterance utterance, SortedMap<String, Body> bodies) {
        Table table = world.table(WorldPrototype.BODY);
        int row = table.rowOf(speaker.id());
        boolean areAllLoaded = false;
        long cost = bodies.size();
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
            if (!perceivesAll && !areAllLoaded) {
                if (hearer.needsSight()) {
                    sensed.load(table);
                    areAllLoaded = true;
                    cost += table.rowCount();
                } else {
                    sensed.load(table, table.rowOf(hearer.id()), row);
                }
            }
            boolean isKnown =
                    perceivesAll
                            || Body.senses(sensed, hearer.sensors(), table.rowOf(hearer.id()), row);
            heard.add(
                    new Heard(
                            other.getKey(),
                            utterance.event(
                                    arrived.get(),
                                    isKnown ? Optional.of(speaker.name()) : Optional.empty(),
                                    at)));
            cost += OF_HEARER;
        }
        return cost;
    }

    /**
     * Returns what agents have heard since the last call, in the order in which it was said, then
     * in the order of the hearers' names.
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
