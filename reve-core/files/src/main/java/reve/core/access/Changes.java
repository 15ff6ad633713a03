// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import reve.core.unit.Unit;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Colour;
import reve.core.world.Force;
import reve.core.world.Forces;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.LevelChange;
import reve.core.world.Possible;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.SemanticAspect;
import reve.core.world.SymbolBytes;
import reve.core.world.WorldEvent;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/**
 * The changes of the world by one call of an action. Either all of them are applied or none. {@link
 * #prepare} first checks everything that can fail, in the state of the world before the call. These
 * checks include physics values that earlier effects of the call set, because several effects may
 * change the same item. Removals are applied last.
 */
final class Changes {
    /**
     * Evaluation steps that an agent spends for each character of a symbol, because every client
     * that perceives the item receives the symbol.
     */
    private static final int STEPS_PER_CHARACTER = 2;

    private static final String PHYSICS = "physics.";
    private static final String SEMANTIC = "semantic.";

    /** Smallest speed along an axis after an impulse [m/s]. A smaller speed counts as 0. */
    private static final double SLOWEST = 1e-30;

    private final ActionCall call;
    private final Map<ItemId, Map<String, double[]>> planned = new HashMap<>();
    private final List<ItemDefinition> created = new ArrayList<>();
    private final Set<Item> removed = new LinkedHashSet<>();
    private long eventBytes;
    private long symbolBytes;
    private int forces;
    private final List<Runnable> all = new ArrayList<>();
    private final List<Runnable> last = new ArrayList<>();

    private Changes(ActionCall call) {
        this.call = call;
    }

    /**
     * Refuses effects that contradict each other.
     *
     * @throws IllegalArgumentException if two effects change the same value; the message names it
     */
    static void requireCompatible(String action, List<Effect> effects) {
        Set<String> changed = new HashSet<>();
        boolean removes = effects.stream().anyMatch(Effect.Remove.class::isInstance);
        boolean attaches = effects.stream().anyMatch(Effect.Attach.class::isInstance);
        for (Effect effect : effects) {
            if (!(effect instanceof Effect.Create) && !changed.add(effect.changes())) {
                throw new IllegalArgumentException(
                        "action " + action + " has two effects that change " + effect.changes());
            }
            if (removes
                    && effect instanceof Effect.Create create
                    && (!create.definition().references().isEmpty()
                            || create.definition().parent().isPresent())) {
                throw new IllegalArgumentException(
                        "action "
                                + action
                                + " removes an item and creates one that refers to others");
            }
            if (attaches
                    && effect instanceof Effect.SetProperty set
                    && set.property().equals("mass")) {
                throw new IllegalArgumentException(
                        "action "
                                + action
                                + " attaches an item and sets a mass; what is attached has none");
            }
        }
    }

    /**
     * Checks all effects and computes their changes. Does not apply them.
     *
     * @throws ActionRefused if an effect is not possible now
     */
    static Changes prepare(ActionCall call, List<Effect> effects) throws ActionRefused {
        var changes = new Changes(call);
        for (Effect effect : effects) {
            Runnable change = changes.prepare(effect);
            boolean isLast = effect instanceof Effect.Remove || changes.isLevel(effect);
            (isLast ? changes.last : changes.all).add(change);
        }
        changes.requireLevelAlone(effects);
        call.quota().require(call.world(), changes.created.size(), changes.removed);
        call.symbols()
                .require(call.world(), call.quota().agent(), call.frame(), changes.symbolGrowth());
        attempt("cannot-create", () -> call.world().requireAddable(changes.created));
        call.events().require(call.quota().agent(), call.frame(), changes.eventBytes);
        call.forces().require(call.quota().agent(), call.frame(), changes.forces);
        return changes;
    }

    /** Applies all prepared changes. Cannot fail. */
    void make() {
        call.events().take(call.quota().agent(), call.frame(), eventBytes);
        long before = call.world().symbolBytes();
        if (!created.isEmpty()) {
            call.world()
                    .addAll(created, call.quota().agent())
                    .forEach(item -> call.world().arrests().suspect(item.id()));
        }
        all.forEach(Runnable::run);
        last.forEach(Runnable::run);
        call.symbols()
                .take(call.quota().agent(), call.frame(), call.world().symbolBytes() - before);
    }

    private Runnable prepare(Effect effect) throws ActionRefused {
        Item item = effect.of().in(call);
        return switch (effect) {
            case Effect.Impulse impulse -> impulse(item, impulse);
            case Effect.Force force -> force(item, force);
            case Effect.SetProperty set -> property(item, set);
            case Effect.SetLocation set -> location(item, set);
            case Effect.SetOrientation set -> orientation(item, set);
            case Effect.SetColour set -> {
                Colour colour = colour(set.to());
                requireBody(item);
                yield () -> item.physical().setColour(colour);
            }
            case Effect.SetSymbol set -> symbol(item, set);
            case Effect.Attach attach -> attach(item, attach.to().in(call));
            case Effect.Detach detach -> detach(item);
            case Effect.Create create -> create(create);
            case Effect.Remove remove -> remove(item);
            case Effect.Raise raise -> raise(raise);
        };
    }

    private Runnable impulse(Item item, Effect.Impulse effect) throws ActionRefused {
        double mass = requireMovable(item, "impulse");
        double[] velocity = physics(item, "velocity").clone();
        double[] kick = numbers(effect.impulse(), 3, Effect.Impulse.UNIT);
        for (int i = 0; i < velocity.length; i++) {
            velocity[i] += kick[i] / mass;
            if (Math.abs(velocity[i]) < SLOWEST) {
                velocity[i] = 0;
            }
        }
        return setting(item, "velocity", velocity);
    }

    private Runnable force(Item item, Effect.Force effect) throws ActionRefused {
        requireMovable(item, "force");
        double[] force = numbers(effect.force(), 3, Effect.Force.UNIT);
        requireFits(item.name(), column(item, "appliedForce"), force);
        Forces forces = call.world().forces();
        var added =
                new Force(
                        item.id(),
                        List.of(force[0], force[1], force[2]),
                        forces.frames(effect.seconds()));
        this.forces++;
        return suspect(
                item,
                () -> {
                    call.forces().take(call.quota().agent(), call.frame(), added.frames());
                    forces.add(added);
                });
    }

    private Runnable property(Item item, Effect.SetProperty effect) throws ActionRefused {
        requirePhysics(item);
        PropertyDescriptor column = column(item, effect.property());
        double[] values = numbers(effect.to(), column.components(), column.unit());
        if (item.parent().isPresent() && effect.property().equals("mass") && values[0] != 0) {
            throw new ActionRefused(
                    "attached",
                    item.name()
                            + " is attached to "
                            + call.world().item(item.parent().get()).name()
                            + ": its mass stays 0");
        }
        return setting(item, effect.property(), values);
    }

    private Runnable location(Item item, Effect.SetLocation effect) throws ActionRefused {
        requireBody(item);
        double[] to = numbers(effect.to(), 3, Effect.SetLocation.UNIT);
        requireFits(
                item.name(), call.world().table(item.kind()).column("position").descriptor(), to);
        return suspect(item, () -> item.physical().setLocation(to[0], to[1], to[2]));
    }

    private Runnable orientation(Item item, Effect.SetOrientation effect) throws ActionRefused {
        requireBody(item);
        double[] to = numbers(effect.to(), 4, Unit.ONE);
        if (to[0] == 0 && to[1] == 0 && to[2] == 0 && to[3] == 0) {
            throw new ActionRefused(
                    "not-a-rotation", item.name() + " cannot be turned by the zero quaternion");
        }
        return () -> item.physical().setOrientation(to[0], to[1], to[2], to[3]);
    }

    private Runnable symbol(Item item, Effect.SetSymbol effect) throws ActionRefused {
        Object value = symbolValue(item.name(), effect.symbol(), effect.to());
        if (item.isLevel(effect.symbol())) {
            call.world().activity().spend(LevelChange.steps(item, value));
            eventBytes += LevelChange.EVENT_BYTES;
            attempt("not-a-level", () -> LevelChange.prepare(call.world(), item, value));
            return () -> LevelChange.prepare(call.world(), item, value).make(call.frame());
        }
        symbolBytes += SymbolBytes.growth(item, effect.symbol(), value);
        return () -> item.semantic().set(effect.symbol(), value);
    }

    /** Returns by how much all changes enlarge the symbols of the world [bytes]. */
    private long symbolGrowth() {
        long growth = symbolBytes;
        for (ItemDefinition item : created) {
            growth += SymbolBytes.of(call.world(), item);
        }
        for (Item item : removed) {
            growth -= SymbolBytes.of(item);
        }
        return growth;
    }

    /** Returns whether an effect changes the level of an item, which may remove other items. */
    private boolean isLevel(Effect effect) throws ActionRefused {
        return effect instanceof Effect.SetSymbol set && effect.of().in(call).isLevel(set.symbol());
    }

    /**
     * Refuses effects that could make a change of a level impossible after it was prepared, or that
     * need an item which this change removes.
     */
    private void requireLevelAlone(List<Effect> effects) throws ActionRefused {
        int levels = 0;
        boolean others = false;
        for (Effect effect : effects) {
            levels += isLevel(effect) ? 1 : 0;
            others |=
                    !(effect instanceof Effect.SetSymbol
                            || effect instanceof Effect.SetColour
                            || effect instanceof Effect.Impulse
                            || effect instanceof Effect.Raise);
        }
        if (levels > 1 || levels == 1 && others) {
            throw new ActionRefused(
                    "not-a-level",
                    "besides one level, an action can change only symbols, colours and velocities"
                            + " (impulse), and raise events; use two actions");
        }
    }

    private Runnable attach(Item child, Item parent) throws ActionRefused {
        attempt(
                "cannot-attach",
                () -> {
                    LevelChange.requireOwnParent(child);
                    call.world().requireAttachable(child.id(), parent.id());
                });
        return () -> call.world().attach(child.id(), parent.id());
    }

    private Runnable detach(Item item) throws ActionRefused {
        if (item.parent().isEmpty()) {
            throw new ActionRefused("not-attached", item.name() + " is not attached to anything");
        }
        attempt("cannot-detach", () -> LevelChange.requireOwnParent(item));
        return () -> call.world().detach(item.id());
    }

    private Runnable remove(Item item) throws ActionRefused {
        attempt("cannot-remove", () -> call.world().requireRemovable(item.id()));
        removed.add(item);
        return () -> call.world().remove(item.id());
    }

    private Runnable create(Effect.Create effect) throws ActionRefused {
        long id = call.world().lastId() + created.size() + 1;
        ItemDefinition.Builder item =
                effect.definition().copy(freeName(effect.definition().name() + "-" + id));
        for (Map.Entry<String, Operand> given : effect.with().entrySet()) {
            give(item, effect.definition().kind(), given.getKey(), given.getValue());
        }
        created.add(item.build());
        return () -> {};
    }

    /**
     * Returns the wanted name. Appends a number if an item or an agent's body already has the name.
     */
    private String freeName(String wanted) {
        String name = wanted;
        for (int number = 2; call.world().find(name).isPresent(); number++) {
            name = wanted + "-" + number;
        }
        return name;
    }

    private void give(ItemDefinition.Builder item, String kind, String name, Operand value)
            throws ActionRefused {
        if (name.startsWith(PHYSICS)) {
            String property = name.substring(PHYSICS.length());
            PropertyDescriptor column = column(kind, property);
            double[] numbers = numbers(value, column.components(), column.unit());
            requireFits(item.name(), column, numbers);
            item.physics(property, numbers);
        } else if (name.startsWith(SEMANTIC)) {
            String symbol = name.substring(SEMANTIC.length());
            item.symbol(symbol, symbolValue(item.name(), symbol, value));
        } else if (name.equals("physical.location")) {
            double[] at = numbers(value, 3, Effect.SetLocation.UNIT);
            item.at(at[0], at[1], at[2]);
        } else if (name.equals("physical.orientation")) {
            double[] turn = numbers(value, 4, Unit.ONE);
            attempt("not-a-rotation", () -> item.orientation(turn[0], turn[1], turn[2], turn[3]));
        } else {
            item.colour(colour(value).toString());
        }
    }

    private Runnable raise(Effect.Raise effect) throws ActionRefused {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("item", call.target().name());
        fields.put("action", effect.action());
        call.actor().ifPresent(actor -> fields.put("actor", actor.name()));
        for (Map.Entry<String, Operand> given : effect.with().entrySet()) {
            fields.put(given.getKey(), given.getValue().symbol(call));
        }
        List<WorldEvent> raised = new ArrayList<>();
        attempt("no-value", () -> raised.add(new WorldEvent(call.frame(), effect.event(), fields)));
        WorldEvent event = raised.getFirst();
        eventBytes += event.bytes();
        return () -> call.world().raise(event);
    }

    private Runnable setting(Item item, String property, double[] values) throws ActionRefused {
        requireFits(item.name(), column(item, property), values);
        planned.computeIfAbsent(item.id(), id -> new HashMap<>()).put(property, values);
        return suspect(item, () -> item.physics().set(property, values));
    }

    /**
     * Returns a change that first records the item as changed by an act. This record names a
     * possible cause if a law fails at the item later.
     */
    private Runnable suspect(Item item, Runnable change) {
        return () -> {
            change.run();
            call.world().arrests().suspect(item.id());
        };
    }

    /** Returns the value that a property has after the effects prepared so far. */
    private double[] physics(Item item, String property) {
        double[] given = planned.getOrDefault(item.id(), Map.of()).get(property);
        return given != null ? given : item.physics().vector(property);
    }

    private Object symbolValue(String item, String symbol, Operand to) throws ActionRefused {
        Object value = to.symbol(call);
        Object[] checked = new Object[1];
        attempt(
                "not-a-symbol",
                () ->
                        checked[0] =
                                SemanticAspect.requireSettable(
                                        call.world().prototype(),
                                        item,
                                        symbol,
                                        inItsUnit(symbol, to, value)));
        call.world().activity().spend(STEPS_PER_CHARACTER * SemanticAspect.characters(checked[0]));
        return checked[0];
    }

    /**
     * Converts the value of an expression, which is in SI units, into the declared unit of the
     * symbol.
     */
    private Object inItsUnit(String symbol, Operand to, Object value) {
        Unit unit =
                call.world()
                        .prototype()
                        .symbol(symbol)
                        .map(declared -> declared.unit())
                        .orElse(Unit.ONE);
        return to instanceof Operand.Computed && value instanceof Double number
                ? number / unit.scale()
                : value;
    }

    private Colour colour(Operand to) throws ActionRefused {
        Object value = to.symbol(call);
        Colour[] colour = new Colour[1];
        attempt("not-a-colour", () -> colour[0] = Colour.parse(value.toString()));
        return colour[0];
    }

    private double requireMovable(Item item, String by) throws ActionRefused {
        requireBody(item);
        requirePhysics(item);
        double mass = physics(item, "mass")[0];
        if (mass == 0) {
            throw new ActionRefused(
                    "immovable", item.name() + " has mass 0: no " + by + " can move it");
        }
        return mass;
    }

    private static void requireBody(Item item) throws ActionRefused {
        if (item.physical().isEmpty()) {
            throw new ActionRefused(
                    "not-a-body", item.name() + " is a " + item.kind() + ", expected a body");
        }
    }

    private static void requirePhysics(Item item) throws ActionRefused {
        if (item.physics().isEmpty()) {
            throw new ActionRefused(
                    "no-physics", item.name() + " is scenery: its physics aspect is empty");
        }
    }

    private static void requireFits(String item, PropertyDescriptor column, double[] values)
            throws ActionRefused {
        Optional<String> why = Possible.refusal(column, values);
        if (why.isPresent()) {
            throw new ActionRefused(
                    "out-of-range",
                    column.name()
                            + " of "
                            + item
                            + " cannot become "
                            + text(values)
                            + ": "
                            + why.get());
        }
    }

    private static String text(double[] values) {
        return values.length == 1 ? Double.toString(values[0]) : Arrays.toString(values);
    }

    private PropertyDescriptor column(Item item, String property) throws ActionRefused {
        return column(item.kind(), property);
    }

    private PropertyDescriptor column(String kind, String property) throws ActionRefused {
        return call.world()
                .prototype()
                .find(kind, property)
                .orElseThrow(
                        () ->
                                new ActionRefused(
                                        "no-such-property",
                                        "items of kind " + kind + " have no property " + property));
    }

    /** Returns the value of an operand as {@code count} finite numbers. */
    private double[] numbers(Operand operand, int count, Unit unit) throws ActionRefused {
        double[] numbers = operand.numbers(call, count, unit);
        boolean finite = true;
        for (double number : numbers) {
            finite &= Double.isFinite(number);
        }
        if (numbers.length != count || !finite) {
            throw new ActionRefused(
                    "no-value",
                    "found "
                            + Arrays.toString(numbers)
                            + ", expected "
                            + count
                            + " finite "
                            + (count == 1 ? "number" : "numbers"));
        }
        for (double number : numbers) {
            Optional<String> why = ScalarType.F64.refusal(number);
            if (why.isPresent()) {
                throw new ActionRefused("out-of-range", "found " + number + "; " + why.get());
            }
        }
        return numbers;
    }

    /** Runs a check of the world, and reports its failure as a refusal of the action. */
    private static void attempt(String code, Runnable check) throws ActionRefused {
        try {
            check.run();
        } catch (IllegalArgumentException refused) {
            throw new ActionRefused(code, refused.getMessage());
        }
    }
}
