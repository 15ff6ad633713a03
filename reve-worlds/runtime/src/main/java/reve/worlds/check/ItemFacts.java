// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.file.WorldDescription;
import reve.core.rule.Expression;
import reve.core.rule.Rule;
import reve.core.world.Action;
import reve.core.world.Instrument;
import reve.core.world.ItemDefinition;
import reve.core.world.Sensor;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.Collection;
import java.util.Collections;
import java.util.HashMap;
import java.util.HashSet;
import java.util.IdentityHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/**
 * The items of a world for the checks. They include the items of the world file, and the items that
 * agents, actions and levels of items may add.
 */
final class ItemFacts {
    /** An item of the world file, and its index in the description. */
    record Entry(int index, ItemDefinition item) {
        String name() {
            return item.name();
        }

        boolean isBody() {
            return item.kind().equals(WorldPrototype.BODY);
        }

        double number(String property) {
            return item.physics(property).map(values -> values[0]).orElse(0.0);
        }

        double mass() {
            return number("mass");
        }

        /** Returns whether laws may move the item. */
        boolean isMovable() {
            return isBody() && mass() > 0 && item.parent().isEmpty();
        }

        boolean has(String property) {
            return ItemFacts.has(item, property);
        }
    }

    private final List<Entry> entries = new ArrayList<>();
    private final Map<String, Entry> byName = new HashMap<>();
    private final List<ItemDefinition> additional = new ArrayList<>();
    private final Set<String> setByActions = new HashSet<>();
    private final Set<String> referredTo = new HashSet<>();
    private final Set<String> carriers = new HashSet<>();
    private final Set<String> readByExpressions = new HashSet<>();
    private boolean pushed;
    private boolean weighed;

    ItemFacts(WorldDescription world) {
        Set<Action> seen = Collections.newSetFromMap(new IdentityHashMap<>());
        for (ItemDefinition item : world.items()) {
            Entry entry = new Entry(entries.size(), item);
            entries.add(entry);
            byName.put(item.name(), entry);
            item.references().values().forEach(referredTo::addAll);
            item.parent().ifPresent(carriers::add);
            readSensors(item);
            readActions(item, seen);
            item.levels()
                    .forEach(level -> level.items().forEach(each -> addAdditional(each, seen)));
        }
        world.agents().template().ifPresent(body -> addAdditional(body, seen));
        for (Rule rule : world.rules()) {
            rule.source().uses().forEach(this::readName);
        }
        weighed |= world.prototype().symbol("strength").isPresent();
    }

    private void addAdditional(ItemDefinition item, Set<Action> seen) {
        additional.add(item);
        item.references().values().forEach(referredTo::addAll);
        readSensors(item);
        readActions(item, seen);
    }

    private void readSensors(ItemDefinition item) {
        weighed |=
                item.sensors().stream()
                        .map(Sensor::instrument)
                        .anyMatch(instrument -> instrument.orElse(null) instanceof Instrument.Imu);
    }

    /** Notes the property that a name such as {@code actor.physics.mass} reads. */
    private void readName(String name) {
        int aspect = name.lastIndexOf("physics.");
        if (aspect >= 0) {
            readByExpressions.add(name.substring(aspect + "physics.".length()));
        }
    }

    private void readOperand(Operand operand) {
        if (operand instanceof Operand.Computed computed) {
            computed.expression().uses().forEach(this::readName);
        }
    }

    private void readActions(ItemDefinition item, Set<Action> seen) {
        for (Action action : item.actions()) {
            if (seen.add(action) && action instanceof DeclaredAction declared) {
                declared.terms().conditions().stream()
                        .map(Expression::uses)
                        .forEach(names -> names.forEach(this::readName));
                for (Effect effect : declared.effects()) {
                    readEffect(effect, seen);
                }
            }
        }
    }

    private void readEffect(Effect effect, Set<Action> seen) {
        switch (effect) {
            case Effect.Impulse impulse -> {
                pushed = true;
                readOperand(impulse.impulse());
            }
            case Effect.Force force -> {
                pushed = true;
                readOperand(force.force());
            }
            case Effect.SetProperty set -> {
                setByActions.add(set.property());
                readOperand(set.to());
            }
            case Effect.SetSymbol set -> readOperand(set.to());
            case Effect.Raise raise -> raise.with().values().forEach(this::readOperand);
            case Effect.Create create -> {
                create.with().values().forEach(this::readOperand);
                addAdditional(create.definition(), seen);
                create.with().keySet().stream()
                        .filter(key -> key.startsWith("physics."))
                        .forEach(key -> setByActions.add(key.substring("physics.".length())));
            }
            case Effect.Attach _,
                    Effect.Detach _,
                    Effect.Remove _,
                    Effect.SetColour _,
                    Effect.SetLocation _,
                    Effect.SetOrientation _ -> {}
        }
    }

    /** Returns the items of the file. */
    List<Entry> all() {
        return entries;
    }

    Optional<Entry> find(String name) {
        return Optional.ofNullable(byName.get(name));
    }

    /** Returns the bodies of the file that laws may move. */
    List<Entry> movable() {
        return entries.stream().filter(Entry::isMovable).toList();
    }

    /** Returns whether a body that laws may move exists, or may exist later. */
    boolean mayMove() {
        return setByActions.contains("mass")
                || entries.stream().anyMatch(Entry::isMovable)
                || additional.stream()
                        .anyMatch(
                                item ->
                                        item.kind().equals(WorldPrototype.BODY)
                                                && has(item, "mass"));
    }

    /** Returns whether an item of a kind with physics exists, or may exist later. */
    boolean mayExist(String kind) {
        return count(kind) > 0
                || additional.stream().anyMatch(item -> item.kind().equals(kind) && physics(item));
    }

    /** Returns the number of items of a kind with physics in the file. */
    int count(String kind) {
        return (int)
                entries.stream()
                        .filter(entry -> entry.item().kind().equals(kind) && physics(entry.item()))
                        .count();
    }

    /**
     * Returns whether an item of the kind has a value other than 0 in one of these properties, or
     * may have one later.
     */
    boolean mayDiffer(String kind, Collection<String> properties) {
        return properties.stream().anyMatch(setByActions::contains)
                || entries.stream()
                        .map(Entry::item)
                        .anyMatch(item -> item.kind().equals(kind) && hasAny(item, properties))
                || additional.stream()
                        .anyMatch(item -> item.kind().equals(kind) && hasAny(item, properties));
    }

    /** Returns whether an effect of an action sets a property. */
    boolean isSetByActions(String property) {
        return setByActions.contains(property);
    }

    /** Returns whether a rule, a condition or a value of an action reads a property of items. */
    boolean isReadByExpressions(String property) {
        return readByExpressions.contains(property);
    }

    /**
     * Returns whether the world itself reads the constant {@code gravity}: for the symbol {@code
     * tooHeavy}, which follows from the symbol {@code strength}, or for an inertial sensor.
     */
    boolean isWeighed() {
        return weighed;
    }

    /** Returns whether another item is attached to an item. */
    boolean isCarrier(Entry entry) {
        return carriers.contains(entry.name());
    }

    /** Returns whether an action pushes items by impulses or forces. */
    boolean isPushed() {
        return pushed;
    }

    /** Returns whether another item, such as a spring or a surface, refers to an item. */
    boolean isReferredTo(Entry entry) {
        return referredTo.contains(entry.name());
    }

    private static boolean physics(ItemDefinition item) {
        return item.hasPhysics();
    }

    private static boolean hasAny(ItemDefinition item, Collection<String> properties) {
        return properties.stream().anyMatch(property -> has(item, property));
    }

    /** Returns whether an item gives a property a value other than 0. */
    static boolean has(ItemDefinition item, String property) {
        return item.physics(property)
                .filter(values -> Arrays.stream(values).anyMatch(value -> value != 0))
                .isPresent();
    }
}
