// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import reve.core.text.Suggestion;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/**
 * A change of the active {@link Level} of an item. The new level has the same mass, centre of mass,
 * orientation, momentum and angular momentum as the former one. It moves like a rigid body, so it
 * does not have the kinetic energy of vibrations. For the world's thread only, outside the phases
 * PHYSICS, DERIVE and PUBLISH.
 */
public final class LevelChange {

    /** Type of the event that reports a change. */
    public static final String EVENT = "level-changed";

    /** Number of evaluation steps that a change costs. It takes as much time as these steps. */
    public static final int STEPS = 1000;

    /** Number of further steps for each part that leaves or enters the world. */
    public static final int STEPS_PER_PART = 500;

    /** Maximum size of the event [bytes]. */
    public static final int EVENT_BYTES = 1024;

    /** Name in place of the item's name, under which the values of new items are checked. */
    private static final String APART = "¿";

    private static final String INERTIA = "inertia";
    private static final String VELOCITY = "velocity";
    private static final String ANGULAR_VELOCITY = "angularVelocity";

    private final World world;
    private final Item item;
    private final Level from;
    private final Level to;

    /** The items whose motion the new level continues, in the order of the former level. */
    private final List<Item> moving;

    private final Motion before;

    /** The centre of mass and the orientation of the item. */
    private final Pose place;

    /** For a group the new parts, otherwise the new state of the item. */
    private final List<ItemDefinition> next;

    private LevelChange(World world, Item item, Level from, Level to) {
        this.world = world;
        this.item = item;
        this.from = from;
        this.to = to;
        moving = moving(world, item, from);
        before = Motion.of(moving);
        place =
                Pose.of(
                        before.centre(),
                        from.isGroup()
                                ? Motion.rotation(from.items(), moving)
                                : item.physical().orientation());
        next = to.isGroup() ? parts() : List.of(body());
    }

    /**
     * Checks whether a level of an item can become active, and changes nothing.
     *
     * @param level name of the level
     * @throws IllegalArgumentException naming the item if it has no such level, its mass is 0, a
     *     part of the active level is missing, another item refers to the item or to a part that
     *     would leave, or the name of a new part is taken
     */
    public static LevelChange prepare(World world, Item item, @Nullable Object level) {
        Level from =
                item.level()
                        .orElseThrow(() -> new IllegalArgumentException(item + " has no levels"));
        Level to =
                item.levels().stream()
                        .filter(each -> each.name().equals(level))
                        .findFirst()
                        .orElseThrow(() -> unknown(item, String.valueOf(level)));
        var change = new LevelChange(world, item, from, to);
        if (from != to) {
            change.requireUnheld();
            change.requireAddable();
        }
        return change;
    }

    private static IllegalArgumentException unknown(Item item, String level) {
        List<String> names = item.levels().stream().map(Level::name).toList();
        return new IllegalArgumentException(
                item
                        + " has no level "
                        + level
                        + "; its levels are "
                        + String.join(", ", names)
                        + Suggestion.of(level, names));
    }

    /**
     * Returns the motion of an item at its active level.
     *
     * @throws IllegalArgumentException naming the item if a part is missing, or the mass is 0
     */
    public static Motion motion(World world, Item item) {
        return Motion.of(moving(world, item, item.level().orElseThrow()));
    }

    /**
     * Returns the number of evaluation steps that a change costs.
     *
     * @param level name of a level of the item, or anything else
     */
    public static long steps(Item item, @Nullable Object level) {
        long parts = item.level().map(each -> each.items().size()).orElse(0);
        for (Level each : item.levels()) {
            parts += each.name().equals(level) ? each.items().size() : 0;
        }
        return STEPS + STEPS_PER_PART * parts;
    }

    /** Returns whether a part at a level of an item has this name, or will have it. */
    public static boolean isOfPart(World world, String name) {
        for (int end = name.indexOf('.'); end >= 0; end = name.indexOf('.', end + 1)) {
            String part = name.substring(end + 1);
            boolean isOfPart =
                    world.find(name.substring(0, end)).stream()
                            .flatMap(item -> item.levels().stream())
                            .filter(Level::isGroup)
                            .flatMap(level -> level.items().stream())
                            .anyMatch(each -> each.name().equals(part));
            if (isOfPart) {
                return true;
            }
        }
        return false;
    }

    /**
     * Checks whether an item may get another parent, or none. While a level with parts is active,
     * the item belongs to its carrier.
     *
     * @throws IllegalArgumentException naming the item and its level
     */
    public static void requireOwnParent(Item item) {
        Level level = item.level().filter(Level::isGroup).orElse(null);
        if (level != null) {
            throw new IllegalArgumentException(
                    item
                            + " is at the level "
                            + level.name()
                            + ", so it stays attached to the part "
                            + level.carrier().name()
                            + "; make a level without parts active first");
        }
    }

    /**
     * Makes the change, and raises an event {@value #EVENT}. Does nothing if the level is active
     * already.
     *
     * @param frame number of the frame, for the event
     * @throws IllegalStateException naming the phase of the frame if it forbids structural changes
     */
    public void make(long frame) {
        if (from == to) {
            return;
        }
        world.guard().requireUnlocked("change the level of " + item);
        if (from.isGroup()) {
            world.detach(item.id());
            removeParts();
        }
        List<Item> now = to.isGroup() ? becomeGroup() : becomeBody();
        item.semantic().restore(Level.SYMBOL, to.name());
        now.forEach(each -> world.arrests().suspect(each.id()));
        raise(frame, Motion.of(now));
    }

    /** Returns the item itself, or the parts of its level. Refuses an item without a mass. */
    private static List<Item> moving(World world, Item item, Level level) {
        List<Item> moving = level.isGroup() ? parts(world, item, level) : List.of(item);
        if (moving.stream().noneMatch(Motion::isMovable)) {
            throw new IllegalArgumentException(
                    item + " has no mass now, so its level cannot change");
        }
        return moving;
    }

    /**
     * Returns the parts of the active level. The item is attached to one of them, whose name shows
     * the beginning of the other names even if the item was renamed. The parts were added together,
     * so their ids follow each other. Another item that got the name of a removed part, such as the
     * body of an agent, is therefore no part.
     */
    private static List<Item> parts(World world, Item item, Level level) {
        String carrier = level.carrier().name();
        String parent = item.parent().map(world::item).map(Item::name).orElse("");
        if (!parent.endsWith(Level.prefix("") + carrier)) {
            throw new IllegalArgumentException(
                    item
                            + " is not attached to the part "
                            + carrier
                            + " of its level "
                            + level.name()
                            + ", so its parts are not known");
        }
        String prefix = parent.substring(0, parent.length() - carrier.length());
        List<Item> parts = new ArrayList<>();
        long first = item.parent().orElseThrow().value() - level.items().indexOf(level.carrier());
        for (ItemDefinition definition : level.items()) {
            String name = prefix + definition.name();
            Item part = world.find(name).orElse(null);
            if (part == null
                    || part.id().value() != first + parts.size()
                    || !part.kind().equals(definition.kind())
                    || part.physics().isEmpty() && definition.hasPhysics()) {
                throw new IllegalArgumentException(
                        item
                                + ": the part "
                                + name
                                + " of the level "
                                + level.name()
                                + " is missing");
            }
            parts.add(part);
        }
        return parts;
    }

    private String prefix() {
        return Level.prefix(item.name());
    }

    /** Refuses the change if other items hold the item or parts that would leave. */
    private void requireUnheld() {
        Set<ItemId> own = new HashSet<>(Set.of(item.id()));
        moving.forEach(each -> own.add(each.id()));
        if (from.isGroup()) {
            requireNone(world.holding(moving.stream().map(Item::id).toList()), own);
        } else if (to.isGroup()) {
            requireNone(world.referring(item.id()).stream().map(Item::id).toList(), own);
        }
    }

    private void requireNone(Iterable<ItemId> others, Set<ItemId> own) {
        for (ItemId other : others) {
            if (!own.contains(other)) {
                throw new IllegalArgumentException(
                        item
                                + " keeps its level "
                                + from.name()
                                + ", because "
                                + world.item(other)
                                + " refers to it or is attached to it; remove that first");
            }
        }
    }

    /**
     * Refuses parts whose names other items have, and values that do not fit the world. The parts
     * that leave free their names, so the values are checked under other names.
     */
    private void requireAddable() {
        for (ItemDefinition part : to.isGroup() ? next : List.<ItemDefinition>of()) {
            Item other = world.find(part.name()).orElse(null);
            if (other != null && !(from.isGroup() && moving.contains(other))) {
                throw new IllegalArgumentException(
                        item
                                + " keeps its level "
                                + from.name()
                                + ", because the name "
                                + part.name()
                                + " of a part of the level "
                                + to.name()
                                + " is taken");
            }
        }
        world.requireAddable(
                next.stream()
                        .map(
                                each ->
                                        to.isGroup()
                                                ? Level.full(
                                                                Level.prefix(APART),
                                                                Level.relative(prefix(), each))
                                                        .build()
                                                : each.renamed(APART))
                        .toList());
    }

    /**
     * Removes the parts of the former level. Items that refer to others are removed first, and
     * parts that refer to each other in a circle together.
     */
    private void removeParts() {
        List<Item> left = moving.reversed();
        while (!left.isEmpty()) {
            List<Item> held = new ArrayList<>();
            for (Item part : left) {
                if (world.isHeld(part.id())) {
                    held.add(part);
                } else {
                    world.remove(part.id());
                }
            }
            if (held.size() == left.size()) {
                world.removeCascade(held.getFirst().id());
                held.removeIf(part -> world.find(part.id()).isEmpty());
            }
            left = held;
        }
    }

    /** Returns the parts of the new level at their places, with their velocities. */
    private List<ItemDefinition> parts() {
        double factor = before.mass() / to.mass();
        double[] rest = Motion.ofDefinitions(to.items()).centre();
        List<ItemDefinition> parts = new ArrayList<>();
        for (ItemDefinition definition : to.items()) {
            parts.add(placed(definition, rest, factor));
        }
        double[] spin = Motion.spinFor(parts, before.angularMomentum());
        parts.replaceAll(part -> withVelocity(part, spin));
        return parts;
    }

    private ItemDefinition placed(ItemDefinition definition, double[] rest, double factor) {
        ItemDefinition.Builder part = Level.full(prefix(), definition);
        if (definition.kind().equals(WorldPrototype.BODY) && definition.parent().isEmpty()) {
            double[] at = definition.location();
            for (int axis = 0; axis < 3; axis++) {
                at[axis] -= rest[axis];
            }
            Pose own = Pose.of(at, definition.orientation()).within(place);
            part.at(own.x(), own.y(), own.z());
            part.orientation(own.qx(), own.qy(), own.qz(), own.qw());
            scale(definition, part, WorldPrototype.MASS, factor);
            scale(definition, part, INERTIA, factor);
        }
        return part.build();
    }

    private static void scale(
            ItemDefinition definition,
            ItemDefinition.Builder into,
            String property,
            double factor) {
        definition
                .physics(property)
                .ifPresent(
                        values ->
                                into.physics(
                                        property,
                                        Arrays.stream(values)
                                                .map(each -> each * factor)
                                                .toArray()));
    }

    private ItemDefinition withVelocity(ItemDefinition part, double[] spin) {
        if (!(Level.massOf(part) > 0)) {
            return part;
        }
        boolean hasInertia =
                part.physics(INERTIA).filter(moments -> !Values.isZero(moments)).isPresent();
        return part.copy(part.name())
                .physics(VELOCITY, before.velocityAt(part.location(), spin))
                .physics(ANGULAR_VELOCITY, hasInertia ? spin : new double[3])
                .build();
    }

    /** Returns the state of the item at the new level. */
    private ItemDefinition body() {
        ItemDefinition level = to.items().getFirst();
        ItemDefinition.Builder body = level.copy(item.name());
        body.at(place.x(), place.y(), place.z());
        scale(level, body, INERTIA, before.mass() / to.mass());
        double[] inertia = body.build().physics(INERTIA).orElseGet(() -> new double[3]);
        return body.physics(WorldPrototype.MASS, before.mass())
                .physics(VELOCITY, before.velocity())
                .physics(
                        ANGULAR_VELOCITY,
                        Motion.spinOf(inertia, place.orientation(), before.angularMomentum()))
                .build();
    }

    private List<Item> becomeGroup() {
        if (!from.isGroup()) {
            item.physics().clear();
            item.physical().setShape(Shape.none());
            if (item.physical().material().isPresent()) {
                item.physical().setMaterial(Optional.empty());
            }
        }
        List<Item> added = world.addAll(next);
        Item carrier = world.find(prefix() + to.carrier().name()).orElseThrow();
        Pose own = Pose.of(carrier.physical().location(), carrier.physical().orientation());
        world.attach(item.id(), carrier.id(), place.relativeTo(own));
        return added;
    }

    private List<Item> becomeBody() {
        ItemDefinition body = next.getFirst();
        PhysicalAspect physical = item.physical();
        physical.setShape(body.shape());
        physical.setMaterial(body.material());
        physical.setColour(body.colour());
        physical.setLocation(place.x(), place.y(), place.z());
        physical.setOrientation(place.qx(), place.qy(), place.qz(), place.qw());
        item.physics().set(WorldPrototype.MASS, before.mass());
        for (PropertyDescriptor property : world.prototype().properties()) {
            if (property.kind().equals(WorldPrototype.BODY) && property.type() != ScalarType.REF) {
                double[] value =
                        body.physics(property.name())
                                .orElseGet(() -> new double[property.components()]);
                if (!Arrays.equals(value, item.physics().vector(property.name()))) {
                    item.physics().set(property.name(), value);
                }
            }
        }
        return List.of(item);
    }

    private void raise(long frame, Motion after) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("item", item.name());
        fields.put("from", from.name());
        fields.put("to", to.name());
        fields.put("mass", after.mass());
        fields.put("momentumBefore", Arrays.toString(before.momentum()));
        fields.put("momentumAfter", Arrays.toString(after.momentum()));
        fields.put("angularMomentumBefore", Arrays.toString(before.angularMomentum()));
        fields.put("angularMomentumAfter", Arrays.toString(after.angularMomentum()));
        fields.put("energyBefore", before.energy());
        fields.put("energyAfter", after.energy());
        fields.put("energyLost", before.energy() - after.energy());
        world.raiseOwn(new WorldEvent(frame, EVENT, fields));
    }
}
