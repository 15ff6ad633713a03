// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;
import org.pcollections.TreePMap;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Everything an item begins with. What can be checked without a world is checked here, the rest by
 * {@link World#add}. Immutable; any number of worlds may use it.
 */
public final class ItemDefinition {

    private final String name;
    private final String kind;
    private final boolean placed;
    private final Shape shape;
    private final Optional<Material> material;
    private final Colour colour;
    private final double[] location;
    private final double[] orientation;
    private final Optional<String> parent;
    private final PMap<String, Object> symbols;
    private final List<Action> actions;
    private final List<String> capabilities;
    private final List<Sensor> sensors;
    private final Named<double[]> numbers;
    private final Named<List<String>> references;

    private ItemDefinition(Builder builder) {
        name = builder.name;
        kind = builder.kind;
        placed = builder.placed;
        shape = builder.shape;
        material = builder.material;
        colour = builder.colour != null ? builder.colour : Colour.defaultOf(shape, material);
        location = builder.location;
        orientation = builder.orientation;
        parent = Optional.ofNullable(builder.parent);
        symbols = builder.symbols;
        actions =
                builder.actionsByName == null
                        ? builder.actions
                        : List.copyOf(builder.actionsByName.values());
        capabilities = builder.capabilities;
        sensors = builder.sensors;
        numbers = builder.numbers;
        references = builder.references;
    }

    /**
     * Begins a definition: kind body, no shape, at the origin, scenery.
     *
     * @throws IllegalArgumentException if the name cannot be seen as it is, see {@link
     *     reve.core.text.VisibleName}
     */
    public static Builder named(String name) {
        return new Builder(Names.requireItemName("item name", name));
    }

    /** As {@link #named}, of an item that a store kept, with whatever name it was kept. */
    public static Builder kept(String name) {
        return new Builder(name);
    }

    /** The same item under another name, for templates. */
    public ItemDefinition renamed(String newName) {
        return copy(newName).build();
    }

    /** The same item with other symbols: text, truth, finite numbers or lists. */
    public ItemDefinition withSymbols(Map<String, Object> otherSymbols) {
        Builder copy = copy(name);
        copy.symbols = TreePMap.empty();
        otherSymbols.forEach(copy::symbol);
        return copy.build();
    }

    /** Begins a definition of another name that has, and shares, all that this one has. */
    public Builder copy(String newName) {
        Builder copy = new Builder(newName);
        copy.kind = kind;
        copy.placed = placed;
        copy.shape = shape;
        copy.material = material;
        copy.colour = colour;
        copy.location = location;
        copy.orientation = orientation;
        copy.parent = parent.orElse(null);
        copy.symbols = symbols;
        copy.actions = actions;
        copy.capabilities = capabilities;
        copy.sensors = sensors;
        copy.numbers = numbers;
        copy.references = references;
        return copy;
    }

    /** The name of the item. */
    public String name() {
        return name;
    }

    /** The kind of the item. */
    public String kind() {
        return kind;
    }

    /** The shape of a body. */
    public Shape shape() {
        return shape;
    }

    /** As given, else {@link Colour#defaultOf}. */
    public Colour colour() {
        return colour;
    }

    /** Material of the whole shape; without it, a mesh shows its own. */
    public Optional<Material> material() {
        return material;
    }

    /** Place of the origin (3) [m]: in the world frame, or in the parent's if there is one. */
    public double[] location() {
        return location.clone();
    }

    /** Unit quaternion xyzw (4), in the same frame as the location. */
    public double[] orientation() {
        return orientation.clone();
    }

    /** Name of the item that this one moves with. */
    public Optional<String> parent() {
        return parent;
    }

    /** Designer's symbols, in alphabetical order: String, Double, Boolean, or a List of such. */
    public PMap<String, Object> symbols() {
        return symbols;
    }

    /** What agents can do with it. */
    public List<Action> actions() {
        return actions;
    }

    /** What the item can do with others, in the order given: {@code grip}. */
    public List<String> capabilities() {
        return capabilities;
    }

    /** What an agent that has the item as its body perceives with. */
    public List<Sensor> sensors() {
        return sensors;
    }

    /** True if the item takes part in physics, else it is scenery. */
    public boolean hasPhysics() {
        return !numbers.isEmpty() || !references.isEmpty();
    }

    /** Names of the numeric physics properties given, in the order given. */
    public List<String> physicsProperties() {
        return numbers.names();
    }

    /** Values of a numeric physics property [its unit], empty if not given. */
    public Optional<double[]> physics(String property) {
        return Optional.ofNullable(numbers.get(property)).map(double[]::clone);
    }

    /** Names of the items that each reference property refers to. */
    public Map<String, List<String>> references() {
        return references.toMap();
    }

    /** Values of the {@link #physicsProperties()}, in their order; not to be changed. */
    List<double[]> physicsValues() {
        return numbers.values();
    }

    /** As {@link #location()}, not to be changed. */
    double[] sharedLocation() {
        return location;
    }

    /** As {@link #orientation()}, not to be changed. */
    double[] sharedOrientation() {
        return orientation;
    }

    boolean hasReferences() {
        return !references.isEmpty();
    }

    /** True if shape, material, colour, place or orientation were given. */
    boolean isPlaced() {
        return placed;
    }

    /** Collects a definition; each method refuses what cannot be right with a message naming it. */
    public static final class Builder {

        private final String name;
        private String kind = WorldPrototype.BODY;
        boolean placed;
        Shape shape = Shape.none();
        Optional<Material> material = Optional.empty();
        @Nullable Colour colour;
        double[] location = {0, 0, 0};
        double[] orientation = {0, 0, 0, 1};
        @Nullable String parent;
        PMap<String, Object> symbols = TreePMap.empty();
        List<Action> actions = List.of();

        /** Takes the place of the list as soon as there is one action more. */
        private @Nullable Map<String, Action> actionsByName;

        List<String> capabilities = List.of();
        List<Sensor> sensors = List.of();
        Named<double[]> numbers = Named.none();
        Named<List<String>> references = Named.none();

        private Builder(String name) {
            this.name = Names.require("item name", name);
        }

        /** The name of the item. */
        public String name() {
            return name;
        }

        /** Sets the kind, {@code body} unless said otherwise. */
        public Builder kind(String newKind) {
            kind = newKind;
            return this;
        }

        /** Sets the shape of a body. */
        public Builder shape(Shape newShape) {
            placed = true;
            shape = newShape;
            return this;
        }

        /** Of the whole shape, instead of materials that come with a mesh. */
        public Builder material(Material newMaterial) {
            placed = true;
            material = Optional.of(newMaterial);
            return this;
        }

        /** As {@link Colour#parse}. */
        public Builder colour(String text) {
            placed = true;
            colour = Colour.parse(text);
            return this;
        }

        /** Place of the origin [m]: in the world frame, or in the parent's if there is one. */
        public Builder at(double x, double y, double z) {
            placed = true;
            location = new double[] {x, y, z};
            Values.requireFinite(name, "position", location);
            return this;
        }

        /** Rotation as a quaternion of any length but 0; it is normalised. */
        public Builder orientation(double x, double y, double z, double w) {
            placed = true;
            orientation = Values.requireRotation(name, x, y, z, w);
            return this;
        }

        /**
         * Attaches the item to another, given by name: location and orientation are then in its
         * frame. See {@link World#attach}.
         */
        public Builder parent(String itemName) {
            parent = itemName;
            return this;
        }

        /** A semantic symbol: text, truth, a finite number, or a list of such. */
        public Builder symbol(String symbol, Object value) {
            symbols = symbols.plus(symbol, Values.requireSymbol(name, symbol, value));
            return this;
        }

        /** Something that agents can do with the item. */
        public Builder action(Action action) {
            if (actionsByName == null) {
                actionsByName = new LinkedHashMap<>();
                for (Action one : actions) {
                    actionsByName.put(one.name(), one);
                }
            }
            if (actionsByName.putIfAbsent(action.name(), action) != null) {
                throw new IllegalArgumentException(
                        "item " + name + " has two actions named " + action.name());
            }
            return this;
        }

        /** Takes place, shape, material and colour from another item, and shares them. */
        public Builder physicalOf(ItemDefinition other) {
            placed = other.placed;
            shape = other.shape;
            material = other.material;
            colour = other.colour;
            location = other.location;
            orientation = other.orientation;
            return this;
        }

        /** Takes all symbols from another item, and shares them. */
        public Builder symbolsOf(ItemDefinition other) {
            symbols = other.symbols;
            return this;
        }

        /** Takes all actions from another item, and shares them. */
        public Builder actionsOf(ItemDefinition other) {
            actions = other.actions;
            actionsByName = null;
            return this;
        }

        /** Takes all properties of its physics aspect from another item, and shares them. */
        public Builder physicsOf(ItemDefinition other) {
            numbers = other.numbers;
            references = other.references;
            return this;
        }

        /** Something that the item, as the body of an agent, can do with others: {@code grip}. */
        public Builder capability(String capability) {
            Names.require("capability of item " + name, capability);
            if (!capabilities.contains(capability)) {
                capabilities = Named.append(capabilities, capability);
            }
            return this;
        }

        /**
         * How an agent that has the item as its body perceives; without any it perceives
         * everything.
         */
        public Builder sensor(Sensor sensor) {
            if (sensors.stream().anyMatch(other -> other.name().equals(sensor.name()))) {
                throw new IllegalArgumentException(
                        "item " + name + " has two sensors named " + sensor.name());
            }
            sensors = Named.append(sensors, sensor);
            return this;
        }

        /** A numeric physics property [its SI unit]. */
        public Builder physics(String property, double... values) {
            Values.requireFinite(name, property, values);
            numbers = numbers.with(property, values.clone());
            return this;
        }

        /** Several numeric physics properties by name, in their order; quicker than one by one. */
        public Builder physics(Map<String, double[]> properties) {
            properties.forEach((property, values) -> Values.requireFinite(name, property, values));
            numbers = numbers.withAll(properties);
            return this;
        }

        /** A physics property that refers to items by name: {@code end1}, {@code vertices}, ... */
        public Builder reference(String property, String... itemNames) {
            references = references.with(property, List.of(itemNames));
            return this;
        }

        /** The definition as it is now. */
        public ItemDefinition build() {
            return new ItemDefinition(this);
        }
    }
}
