// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import reve.core.agent.auth.Rights;
import reve.core.agent.perception.SensedWorld;
import reve.core.agent.protocol.ActionRequest;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.Text;
import reve.core.file.AgentPolicy;
import reve.core.text.Visible;
import reve.core.world.Action;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Arguments;
import reve.core.world.Departure;
import reve.core.world.EventBudget;
import reve.core.world.ForceBudget;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.ItemQuota;
import reve.core.world.LevelChange;
import reve.core.world.Parameter;
import reve.core.world.ParameterType;
import reve.core.world.Sensor;
import reve.core.world.SymbolBudget;
import reve.core.world.Table;
import reve.core.world.Voice;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;

import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalInt;
import java.util.Set;
import java.util.SortedMap;
import java.util.TreeMap;
import java.util.TreeSet;
import java.util.stream.Collectors;

/**
 * The agents in a world and their bodies. Checks and applies the inputs of agents. The same inputs
 * in the same frames and order produce the same world, whether they come from connections or from a
 * recording. For the world's thread only.
 */
public final class Embodiment {

    /**
     * Codes of refusals whose messages contain details of the world. Agents with limited sensors
     * must not receive these messages.
     */
    private static final Set<String> TELLING =
            Set.of(
                    "condition-failed",
                    "no-value",
                    "immovable",
                    "no-physics",
                    "not-a-body",
                    "attached",
                    "not-attached",
                    "cannot-attach",
                    "cannot-detach",
                    "cannot-create",
                    "cannot-remove",
                    "no-such-item",
                    "no-such-property",
                    "out-of-range",
                    "not-a-rotation",
                    "not-a-colour",
                    "not-a-symbol",
                    "not-a-level");

    /** Code of the refusal after an error inside an action. The log contains the error. */
    private static final String ACTION_FAILED = "action-failed";

    private final AgentPolicy policy;

    /**
     * The bodies by name of the agent. Utterances reach the hearers in the order of these names, so
     * that a replay has the same order.
     */
    private final SortedMap<String, Body> bodies = new TreeMap<>();

    private final Set<String> lent = new HashSet<>();
    private final SensedWorld sensed = new SensedWorld();
    private final EventBudget events;
    private final Speech speech;
    private final ForceBudget forces = new ForceBudget();
    private final SymbolBudget symbols;
    private final StepBudget steps = new StepBudget();

    /**
     * @param policy the bodies and limits that the world grants to agents
     * @param framesPerSecond frames per second of world time
     */
    public Embodiment(AgentPolicy policy, int framesPerSecond) {
        this.policy = policy;
        this.events =
                new EventBudget(policy.eventBytes(), policy.worldEventBytes(), framesPerSecond);
        this.symbols = new SymbolBudget(framesPerSecond);
        this.speech = new Speech(events);
    }

    /** Checks and applies an input completely or not at all. Called outside the phase PHYSICS. */
    public Outcome apply(World world, long frame, AgentInput input) {
        try {
            return switch (input) {
                case AgentInput.Join join -> join(world, frame, join);
                case AgentInput.Act act -> act(world, frame, act);
                case AgentInput.Edit edit -> {
                    ItemEdit.apply(world, frame, edit);
                    yield new Outcome.Done(frame);
                }
                case AgentInput.Late late -> late(world, frame, late);
                case AgentInput.Back back -> back(world, frame, back);
                case AgentInput.Leave leave -> leave(world, frame, leave);
            };
        } catch (CloseReason e) {
            return new Outcome.Refused(frame, e.code(), e.getMessage(), e.hint());
        } catch (ActionRefused e) {
            return e.code().equals(ACTION_FAILED)
                    ? new Outcome.Failed(frame, e)
                    : new Outcome.Refused(
                            frame,
                            e.code(),
                            Visible.line(String.valueOf(e.getMessage())),
                            Optional.empty());
        } catch (RuntimeException e) {
            return new Outcome.Failed(frame, e);
        }
    }

    /** Returns the ids of the agents' bodies, by agent. */
    public Map<String, ItemId> bodies() {
        var ids = new TreeMap<String, ItemId>();
        bodies.forEach((agent, body) -> ids.put(agent, body.id()));
        return ids;
    }

    /**
     * A body as another server continues it.
     *
     * @param place index of the place at which it was created, if it was created at one
     */
    public record Granted(ItemId id, OptionalInt place) {}

    /** Returns the body of an agent; empty if the agent is not in the world. */
    public Optional<Granted> granted(String agent) {
        return Optional.ofNullable(bodies.get(agent))
                .map(body -> new Granted(body.id(), body.place()));
    }

    /**
     * Gives an agent the body that it had on another server. Changes nothing in the world.
     *
     * @param frame the last frame of the world
     * @return empty if the world has no such item, or another agent has it
     */
    public Optional<Outcome.Joined> restore(
            World world, long frame, String agent, Granted granted, Rights rights) {
        Optional<Item> item = world.find(granted.id());
        boolean isMade = isMade(world, granted.id());
        if (item.isEmpty()
                || bodies.containsKey(agent)
                || !isMade && !lent.add(item.get().name())) {
            return Optional.empty();
        }
        Item own = item.get();
        Body body = new Body(own.id(), own.name(), isMade, granted.place(), own.sensors(), rights);
        bodies.put(agent, body);
        return Optional.of(new Outcome.Joined(frame, body.name(), body.id(), body.sensors()));
    }

    /** Returns the bodies that were created for agents. */
    public List<ItemId> made() {
        return bodies.values().stream().filter(Body::made).map(Body::id).sorted().toList();
    }

    /**
     * Assigns bodies after a rewind of the world. An agent that was granted an existing item as its
     * body keeps this item. Any other agent gets the body that was created for it in the restored
     * state, or a new body if none was created for it. Removes the bodies of agents that have left
     * since that state.
     *
     * @param former the bodies by agent, as {@link #bodies} returned them at the restored frame
     * @return Joined for each agent in the world, or Refused for each agent that can no longer have
     *     a body and has left
     */
    public Map<String, Outcome> rewound(World world, long frame, Map<String, ItemId> former) {
        former.forEach(
                (agent, id) -> {
                    Body now = bodies.get(agent);
                    if ((now == null || !now.made()) && isMade(world, id)) {
                        String body = world.item(id).name();
                        Departure.of(world, id).raise(world, frame, agent, body);
                    }
                });
        var outcomes = new TreeMap<String, Outcome>();
        for (String agent : List.copyOf(new TreeMap<>(bodies).keySet())) {
            outcomes.put(
                    agent, rewound(world, frame, agent, Optional.ofNullable(former.get(agent))));
        }
        return outcomes;
    }

    private Outcome rewound(World world, long frame, String agent, Optional<ItemId> former) {
        Body before = bodies.get(agent);
        try {
            Body now = before.made() ? embody(world, agent, former, before) : before;
            bodies.put(agent, now);
            if (!now.id().equals(before.id())) {
                raiseJoined(world, frame, agent, now);
            }
            return new Outcome.Joined(frame, now.name(), now.id(), now.sensors());
        } catch (CloseReason e) {
            bodies.remove(agent);
            raiseLeft(world, frame, agent, before, "rewound");
            return new Outcome.Refused(frame, e.code(), e.getMessage(), e.hint());
        }
    }

    private Body embody(World world, String agent, Optional<ItemId> former, Body before)
            throws CloseReason {
        Optional<Item> own = former.filter(id -> isMade(world, id)).flatMap(world::find);
        if (own.isPresent()) {
            return new Body(
                    own.get().id(),
                    own.get().name(),
                    true,
                    before.place(),
                    own.get().sensors(),
                    before.rights());
        }
        return make(world, agent, policy.template().orElseThrow(), before.place(), before.rights());
    }

    private boolean isMade(World world, ItemId id) {
        return world.find(id).filter(item -> !policy.bodies().contains(item.name())).isPresent();
    }

    /**
     * Returns whether the agent may act now. An agent that has used up its evaluation steps must
     * wait for a later frame.
     */
    boolean mayAct(World world, String agent, long frame) {
        world.charges().take().forEach((who, cost) -> steps.charge(who, frame, cost));
        return steps.hasLeft(agent, frame);
    }

    private Outcome act(World world, long frame, AgentInput.Act act) throws ActionRefused {
        Body body = bodies.get(act.agent());
        if (body == null) {
            return new Outcome.Absent();
        }
        if (perform(world, frame, act.agent(), body, act.requested())) {
            raiseActed(world, frame, act.agent(), body, act.requested());
        }
        return new Outcome.Done(frame);
    }

    private static void raiseActed(
            World world, long frame, String agent, Body body, ActionRequest requested) {
        world.raise(
                new WorldEvent(
                        frame,
                        "acted",
                        fields(
                                "agent",
                                agent,
                                "item",
                                requested.item().orElse(body.name()),
                                "action",
                                requested.action())));
    }

    private Outcome late(World world, long frame, AgentInput.Late late) throws ActionRefused {
        Body body = bodies.get(late.agent());
        if (body == null) {
            return new Outcome.Absent();
        }
        if (late.told()) {
            Map<String, Object> fields = fields("agent", late.agent(), "body", body.name());
            fields.put("count", late.count());
            world.raise(new WorldEvent(frame, "late", fields));
        }
        if (late.away()) {
            world.raise(
                    new WorldEvent(
                            frame, "away", fields("agent", late.agent(), "body", body.name())));
        }
        if (late.fallback().isPresent() && mayAct(world, late.agent(), frame)) {
            boolean acted = perform(world, frame, late.agent(), body, late.fallback().get());
            if (acted && late.told()) {
                raiseActed(world, frame, late.agent(), body, late.fallback().get());
            }
        }
        return new Outcome.Done(frame);
    }

    private Outcome back(World world, long frame, AgentInput.Back back) {
        Body body = bodies.get(back.agent());
        if (body == null) {
            return new Outcome.Absent();
        }
        world.raise(
                new WorldEvent(frame, "back", fields("agent", back.agent(), "body", body.name())));
        return new Outcome.Done(frame);
    }

    /**
     * Performs the requested action, or lets the agent speak.
     *
     * @return true for an action of an item, false if the agent spoke
     */
    private boolean perform(
            World world, long frame, String agent, Body body, ActionRequest requested)
            throws ActionRefused {
        long before = world.activity().steps();
        Optional<Item> speaker = speaker(world, body, requested);
        long extra =
                speaker.isEmpty() && body.needsSight()
                        ? world.table(WorldPrototype.BODY).rowCount()
                        : 0;
        world.charges().begin(agent);
        try {
            if (speaker.isPresent()) {
                extra =
                        speech.say(
                                world, frame, agent, speaker.get(), requested.arguments(), bodies);
            } else {
                act(world, frame, agent, body, requested);
            }
        } finally {
            world.charges().end();
            steps.spend(agent, frame, extra + world.activity().steps() - before);
        }
        return speaker.isEmpty();
    }

    /** Returns the agent's body if it has a voice and the agent requests to speak with it. */
    private static Optional<Item> speaker(World world, Body body, ActionRequest requested) {
        if (!requested.action().equals(Voice.SAY)) {
            return Optional.empty();
        }
        return body.in(world)
                .filter(
                        item ->
                                item.voice().isPresent()
                                        && !item.physical().isEmpty()
                                        && requested
                                                .item()
                                                .orElse(item.name())
                                                .equals(item.name()));
    }

    /**
     * Returns the utterances that agents have heard since the last call; see {@link
     * Speech#takeHeard}.
     */
    public List<Heard> takeHeard() {
        return speech.takeHeard();
    }

    private void act(World world, long frame, String agent, Body body, ActionRequest requested)
            throws ActionRefused {
        Item item = find(world, body, requested.item().orElse(body.name()));
        if (!sensesActions(world, body, item)) {
            throw new ActionRefused(
                    "no-such-action",
                    "you sense no actions of the item " + Text.quote(item.name()));
        }
        Action action =
                item.access()
                        .find(requested.action())
                        .orElseThrow(() -> noSuchAction(body, item, requested.action()));
        Arguments arguments = Arguments.check(action, requested.arguments());
        for (Parameter parameter : action.parameters()) {
            if (parameter.type() == ParameterType.ITEM && !body.sensors().isEmpty()) {
                find(world, body, arguments.text(parameter.name()));
            }
        }
        Optional<Item> actor = body.in(world);
        perform(
                action,
                body,
                new ActionCall(
                        world,
                        frame,
                        item,
                        actor,
                        arguments,
                        actor.map(body::capabilities).orElse(List.of()),
                        new ItemQuota(agent, policy.items(), policy.worldItems()),
                        events,
                        forces,
                        symbols));
    }

    /**
     * Performs an action. The details are hidden from agents with limited sensors if the action is
     * refused.
     */
    private static void perform(Action action, Body body, ActionCall call) throws ActionRefused {
        try {
            call.perform(action);
        } catch (ActionRefused e) {
            if (body.sensors().isEmpty() || !TELLING.contains(e.code())) {
                throw e;
            }
            throw new ActionRefused(
                    e.code(),
                    "the action "
                            + Text.quote(action.name())
                            + " of item "
                            + Text.quote(call.target().name())
                            + " cannot be done now",
                    e);
        }
    }

    /**
     * Finds the item with an action. Refuses an item that the agent does not sense with the same
     * message as an item that does not exist.
     */
    private Item find(World world, Body body, String name) throws ActionRefused {
        Optional<Item> item = world.find(name);
        if (body.sensors().isEmpty()) {
            return item.orElseThrow(
                    () ->
                            new ActionRefused(
                                    "no-such-item", "the world has no item " + Text.quote(name)));
        }
        return item.filter(found -> senses(world, body, body.sensors(), found.id()))
                .orElseThrow(
                        () ->
                                new ActionRefused(
                                        "no-such-item", "you sense no item " + Text.quote(name)));
    }

    private boolean sensesActions(World world, Body body, Item item) {
        return body.ofActions().size() == body.sensors().size()
                || senses(world, body, body.ofActions(), item.id());
    }

    private boolean senses(World world, Body body, List<Sensor> sensors, ItemId item) {
        Table bodies = world.table(WorldPrototype.BODY);
        int eye = bodies.rowOf(body.id());
        int row = bodies.rowOf(item);
        if (eye >= 0 && row >= 0) {
            if (body.needsSight()) {
                sensed.load(bodies);
            } else {
                sensed.load(bodies, eye, row);
            }
        }
        return item.equals(body.id()) || Body.senses(sensed, sensors, eye, row);
    }

    private static ActionRefused noSuchAction(Body body, Item item, String wanted) {
        boolean speaks = wanted.equals(Voice.SAY) && item.id().equals(body.id());
        List<String> names = item.access().actions().stream().map(Action::name).toList();
        return new ActionRefused(
                "no-such-action",
                "the item "
                        + Text.quote(item.name())
                        + " has no action "
                        + Text.quote(wanted)
                        + (names.isEmpty() ? "; it has none" : "; it has " + names)
                        + (speaks ? ". Your body has no `voice` in the world file" : ""));
    }

    private Outcome join(World world, long frame, AgentInput.Join join) throws CloseReason {
        if (bodies.containsKey(join.agent())) {
            throw CloseReason.nameTaken(join.agent());
        }
        if (bodies.size() >= Math.max(policy.most(), policy.bodies().size())) {
            throw CloseReason.refused(
                    "world-full",
                    "world "
                            + world.name()
                            + " has "
                            + bodies.size()
                            + " agents, which is all it takes",
                    "try again when an agent has left");
        }
        Body body = take(world, join);
        bodies.put(join.agent(), body);
        raiseJoined(world, frame, join.agent(), body);
        return new Outcome.Joined(frame, body.name(), body.id(), body.sensors());
    }

    /**
     * Removes an agent from the world. Its body may have been removed earlier, for example by an
     * action.
     */
    private Outcome leave(World world, long frame, AgentInput.Leave leave) {
        Body body = bodies.remove(leave.agent());
        if (body == null) {
            return new Outcome.Absent();
        }
        lent.remove(body.name());
        if (body.made() && body.in(world).isPresent()) {
            Departure.of(world, body.id()).raise(world, frame, leave.agent(), body.name());
        }
        raiseLeft(world, frame, leave.agent(), body, leave.reason());
        return new Outcome.Done(frame);
    }

    private static void raiseJoined(World world, long frame, String agent, Body body) {
        world.raise(new WorldEvent(frame, "joined", fields("agent", agent, "body", body.name())));
    }

    private static void raiseLeft(World world, long frame, String agent, Body body, String reason) {
        world.raise(
                new WorldEvent(
                        frame,
                        "left",
                        fields("agent", agent, "body", body.name(), "reason", reason)));
    }

    /**
     * Chooses a body for an agent: the requested item, otherwise a free item, otherwise a new item.
     * An agent that has the same name as an item gets this item or no body. Otherwise, other agents
     * could not distinguish the agent from the item.
     */
    private Body take(World world, AgentInput.Join join) throws CloseReason {
        Rights rights = join.rights();
        if (policy.bodies().isEmpty() && policy.template().isEmpty()) {
            throw CloseReason.refused(
                    "no-bodies",
                    "world " + world.name() + " grants agents no body",
                    "add `agents: {body: {...}}` or `agents: {bodies: [item, ...]}` "
                            + "to the world file");
        }
        Optional<Item> namesake = world.find(join.agent());
        if (namesake.isPresent()) {
            String name = join.agent();
            if (!policy.bodies().contains(name)
                    || lent.contains(name)
                    || !rights.opensBody(name)
                    || !join.body().orElse(name).equals(name)) {
                throw CloseReason.nameTaken(name);
            }
            return lend(namesake.get(), rights);
        }
        if (join.body().isPresent()) {
            return lend(requireFree(world, join.body().get(), rights), rights);
        }
        for (String name : policy.bodies()) {
            Optional<Item> item = world.find(name);
            if (item.isPresent() && !lent.contains(name) && rights.opensBody(name)) {
                return lend(item.get(), rights);
            }
        }
        if (rights.bodies().isPresent()) {
            throw CloseReason.refused(
                    "no-body-free",
                    "no body that your token opens is free in world " + world.name(),
                    "it opens " + new TreeSet<>(rights.bodies().get()));
        }
        ItemDefinition template =
                policy.template()
                        .orElseThrow(
                                () ->
                                        CloseReason.refused(
                                                "no-body-free",
                                                "all bodies that world "
                                                        + world.name()
                                                        + " lends to agents are taken",
                                                "try again when an agent has left"));
        return make(world, join.agent(), template, freePlace(world), rights);
    }

    private Item requireFree(World world, String name, Rights rights) throws CloseReason {
        if (!rights.opensBody(name)) {
            throw CloseReason.refused(
                    "not-permitted",
                    "your token does not open the body " + Text.quote(name),
                    "it opens " + new TreeSet<>(rights.bodies().orElseThrow()));
        }
        if (!policy.bodies().contains(name)) {
            throw CloseReason.refused(
                    "no-such-body",
                    "world " + world.name() + " lends agents no item " + Text.quote(name),
                    "it lends " + policy.bodies());
        }
        if (lent.contains(name)) {
            throw CloseReason.refused(
                    "body-taken",
                    "another agent has the body " + Text.quote(name),
                    "leave out body to get any that is free");
        }
        return world.find(name)
                .orElseThrow(
                        () ->
                                CloseReason.refused(
                                        "no-such-body",
                                        "the item "
                                                + Text.quote(name)
                                                + " is no longer in world "
                                                + world.name(),
                                        "leave out body to get any that is free"));
    }

    private Body lend(Item item, Rights rights) {
        lent.add(item.name());
        return new Body(item.id(), item.name(), false, OptionalInt.empty(), item.sensors(), rights);
    }

    /** Returns the index of the first place for new bodies that no present agent uses. */
    private OptionalInt freePlace(World world) throws CloseReason {
        if (policy.places().isEmpty()) {
            return OptionalInt.empty();
        }
        Set<Integer> taken =
                bodies.values().stream()
                        .flatMapToInt(body -> body.place().stream())
                        .boxed()
                        .collect(Collectors.toSet());
        for (int place = 0; place < policy.places().size(); place++) {
            if (!taken.contains(place)) {
                return OptionalInt.of(place);
            }
        }
        throw CloseReason.refused(
                "no-body-free",
                "all "
                        + policy.places().size()
                        + " places of agents' bodies in world "
                        + world.name()
                        + " are taken",
                "try again when an agent has left");
    }

    private Body make(
            World world, String agent, ItemDefinition template, OptionalInt place, Rights rights)
            throws CloseReason {
        if (world.find(agent).isPresent() || LevelChange.isOfPart(world, agent)) {
            throw CloseReason.nameTaken(agent);
        }
        try {
            ItemDefinition.Builder body = template.copy(agent);
            place.ifPresent(
                    number -> {
                        AgentPolicy.Place at = policy.places().get(number);
                        body.at(at.x(), at.y(), at.z());
                    });
            Item item = world.add(body.build());
            return new Body(item.id(), item.name(), true, place, item.sensors(), rights);
        } catch (RuntimeException e) {
            throw CloseReason.refused(
                    "no-body-free",
                    "the body could not be made: " + e.getMessage(),
                    "correct agents.body in the world file");
        }
    }

    /**
     * Returns an event's fields. The arguments alternate between a name and its value. The fields
     * keep the order of the arguments.
     */
    private static Map<String, Object> fields(String... namesAndValues) {
        var fields = new LinkedHashMap<String, Object>();
        for (int i = 0; i < namesAndValues.length; i += 2) {
            fields.put(namesAndValues[i], namesAndValues[i + 1]);
        }
        return fields;
    }
}
