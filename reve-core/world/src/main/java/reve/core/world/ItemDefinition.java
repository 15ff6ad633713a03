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
 * The initial state of an item. This class makes the checks that need no world, and {@link
 * World#add} makes all other checks. Immutable. Worlds may share a definition.
 */
public final class ItemDefinition {

    private final String name;
    private final String kind;
    private final boolean placed;
    private final Shape shape;
    private final Optional<Material> material;
    private final Colour colour;
    private final ConnectionLook look;
    private final double[] location;
    private final double[] orientation;
    private final Optional<String> parent;
    private final PMap<String, Object> symbols;
    private final List<Action> actions;
    private final List<String> capabilities;
    private final List<Sensor> sensors;
    private final Optional<Voice> voice;
    private final List<Level> levels;
    private final Named<double[]> numbers;
    private final Named<List<String>> references;

    private ItemDefinition(Builder builder) {
        name = builder.name;
        kind = builder.kind;
        placed = builder.placed;
        shape = builder.shape;
        material = builder.material;
        colour = builder.colour != null ? builder.colour : Colour.defaultOf(shape, material);
        look = builder.look;
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
        voice = builder.voice;
        Voice.requireNoAction(name, voice, actions);
        levels = builder.levels;
        numbers = builder.numbers;
        references = builder.references;
    }

    /**
     * Begins a definition with the defaults: kind {@code body}, no shape, at the origin, no
     * physics.
     *
     * @throws IllegalArgumentException if the name has invisible or misleading characters, see
     *     {@link reve.core.text.VisibleName}
     */
    public static Builder named(String name) {
        return new Builder(Names.requireItemName("item name", name));
    }

    /**
     * Begins a definition without the check by {@link reve.core.text.VisibleName}, for names that
     * were checked before, such as those in a store file.
     */
    public static Builder kept(String name) {
        return new Builder(name);
    }

    /** Returns a copy with another name, for items that are created from a template. */
    public ItemDefinition renamed(String newName) {
        return copy(newName).build();
    }

    /**
     * Returns a copy with other symbols, which replace those of this definition. Their values are
     * texts, truth values, finite numbers or lists.
     */
    public ItemDefinition withSymbols(Map<String, Object> otherSymbols) {
        Builder copy = copy(name);
        copy.symbols = TreePMap.empty();
        otherSymbols.forEach(copy::symbol);
        return copy.build();
    }

    /** Begins a definition that has another name and the content of this definition. */
    public Builder copy(String newName) {
        Builder copy = new Builder(newName);
        copy.kind = kind;
        copy.placed = placed;
        copy.shape = shape;
        copy.material = material;
        copy.colour = colour;
        copy.look = look;
        copy.location = location;
        copy.orientation = orientation;
        copy.parent = parent.orElse(null);
        copy.symbols = symbols;
        copy.actions = actions;
        copy.capabilities = capabilities;
        copy.sensors = sensors;
        copy.voice = voice;
        copy.levels = levels;
        copy.numbers = numbers;
        copy.references = references;
        return copy;
    }

    /** Returns the name of the item. */
    public String name() {
        return name;
    }

    /** Returns the kind of the item. */
    public String kind() {
        return kind;
    }

    /** Returns the shape of a body. */
    public Shape shape() {
        return shape;
    }

    /** Returns the declared colour, or the default of {@link Colour#defaultOf}. */
    public Colour colour() {
        return colour;
    }

    /** Returns the appearance of a spring or surface; the default for other kinds. */
    public ConnectionLook look() {
        return look;
    }

    /**
     * Returns the material of the whole shape. A mesh keeps the materials of its file if the result
     * is empty.
     */
    public Optional<Material> material() {
        return material;
    }

    /**
     * Returns the location of the origin (3) [m]: in the world's reference frame, or relative to
     * the parent if there is one.
     */
    public double[] location() {
        return location.clone();
    }

    /** Returns the unit quaternion xyzw (4), in the same reference frame as the location. */
    public double[] orientation() {
        return orientation.clone();
    }

    /** Returns the name of the parent. */
    public Optional<String> parent() {
        return parent;
    }

    /**
     * Returns the designer's symbols, in alphabetical order: String, Double, Boolean, or a List of
     * these.
     */
    public PMap<String, Object> symbols() {
        return symbols;
    }

    /** Returns the actions on the item. */
    public List<Action> actions() {
        return actions;
    }

    /** Returns the capabilities, in the order given, for example {@code grip}. */
    public List<String> capabilities() {
        return capabilities;
    }

    /** Returns the sensors for an agent with this item as its body. */
    public List<Sensor> sensors() {
        return sensors;
    }

    /** Returns the voice of an agent with this item as its body; empty if it cannot speak. */
    public Optional<Voice> voice() {
        return voice;
    }

    /**
     * Returns the levels, which are several physical descriptions of the item; empty for most
     * items. The symbol {@link Level#SYMBOL} contains the name of the active level.
     */
    public List<Level> levels() {
        return levels;
    }

    /** Returns whether laws act on the item. An item on which they do not act is scenery. */
    public boolean hasPhysics() {
        return !numbers.isEmpty() || !references.isEmpty();
    }

    /** Returns the names of the numeric physics properties, in the order given. */
    public List<String> physicsProperties() {
        return numbers.names();
    }

    /** Returns the values of a numeric physics property, in its unit; empty if not given. */
    public Optional<double[]> physics(String property) {
        return Optional.ofNullable(numbers.get(property)).map(double[]::clone);
    }

    /**
     * Returns, for each reference property such as {@code end1}, the names of the items that it
     * refers to.
     */
    public Map<String, List<String>> references() {
        return references.toMap();
    }

    /**
     * Returns the values of the {@link #physicsProperties()}, in their order. The caller must not
     * change them.
     */
    List<double[]> physicsValues() {
        return numbers.values();
    }

    /** Returns the array of {@link #location()}. The caller must not change it. */
    double[] sharedLocation() {
        return location;
    }

    /** Returns the array of {@link #orientation()}. The caller must not change it. */
    double[] sharedOrientation() {
        return orientation;
    }

    boolean hasReferences() {
        return !references.isEmpty();
    }

    /** Returns whether shape, material, colour, location or orientation were given. */
    boolean isPlaced() {
        return placed;
    }

    /**
     * Builder of a definition. Each method refuses invalid values with a message that names the
     * item.
     */
    public static final class Builder {

        private final String name;
        private String kind = WorldPrototype.BODY;
        boolean placed;
        Shape shape = Shape.none();
        Optional<Material> material = Optional.empty();
        @Nullable Colour colour;
        ConnectionLook look = ConnectionLook.DEFAULT;
        double[] location = {0, 0, 0};
        double[] orientation = {0, 0, 0, 1};
        @Nullable String parent;
        PMap<String, Object> symbols = TreePMap.empty();
        List<Action> actions = List.of();

        /**
         * The actions by name. This map replaces {@link #actions} as soon as {@link #action} is
         * called; null before.
         */
        private @Nullable Map<String, Action> actionsByName;

        List<String> capabilities = List.of();
        List<Sensor> sensors = List.of();
        Optional<Voice> voice = Optional.empty();
        List<Level> levels = List.of();
        Named<double[]> numbers = Named.none();
        Named<List<String>> references = Named.none();

        private Builder(String name) {
            this.name = Names.require("item name", name);
        }

        /** Returns the name of the item. */
        public String name() {
            return name;
        }

        /** Sets the kind. The default is {@code body}. */
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

        /** Sets the material of the whole shape, instead of a mesh's own materials. */
        public Builder material(Material newMaterial) {
            placed = true;
            material = Optional.of(newMaterial);
            return this;
        }

        /** Sets the colour. The text has one of the forms of {@link Colour#parse}. */
        public Builder colour(String text) {
            placed = true;
            colour = Colour.parse(text);
            return this;
        }

        /** Sets the appearance of a spring or surface. */
        public Builder look(ConnectionLook newLook) {
            look = newLook;
            return this;
        }

        /** Returns the appearance of a spring or surface. */
        public ConnectionLook look() {
            return look;
        }

        /**
         * Sets the location of the origin [m]: in the world's reference frame, or relative to the
         * parent if there is one.
         */
        public Builder at(double x, double y, double z) {
            placed = true;
            location = new double[] {x, y, z};
            Values.requireFinite(name, "position", location);
            return this;
        }

        /** Sets the rotation as a quaternion of any length except 0, which is normalised. */
        public Builder orientation(double x, double y, double z, double w) {
            placed = true;
            orientation = Values.requireRotation(name, x, y, z, w);
            return this;
        }

        /**
         * Attaches the item to another item, given by name. Location and orientation are then
         * relative to that item. See {@link World#attach}.
         */
        public Builder parent(String itemName) {
            parent = itemName;
            return this;
        }

        /** Adds a semantic symbol: text, truth, a finite number, or a list of these. */
        public Builder symbol(String symbol, Object value) {
            symbols = symbols.plus(symbol, Values.requireSymbol(name, symbol, value));
            return this;
        }

        /** Adds an action on the item. */
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

        /** Takes place, shape and appearance from another definition, without a copy. */
        public Builder physicalOf(ItemDefinition other) {
            placed = other.placed;
            shape = other.shape;
            material = other.material;
            colour = other.colour;
            look = other.look;
            location = other.location;
            orientation = other.orientation;
            return this;
        }

        /** Takes all symbols from another definition, without a copy. */
        public Builder symbolsOf(ItemDefinition other) {
            symbols = other.symbols;
            return this;
        }

        /** Takes all actions from another definition, without a copy. */
        public Builder actionsOf(ItemDefinition other) {
            actions = other.actions;
            actionsByName = null;
            return this;
        }

        /** Takes all physics properties from another definition, without a copy. */
        public Builder physicsOf(ItemDefinition other) {
            numbers = other.numbers;
            references = other.references;
            return this;
        }

        /** Adds a capability of the item as the body of an agent, for example {@code grip}. */
        public Builder capability(String capability) {
            Names.require("capability of item " + name, capability);
            if (!capabilities.contains(capability)) {
                capabilities = Named.append(capabilities, capability);
            }
            return this;
        }

        /**
         * Adds a sensor for an agent with the item as its body. The agent of a body without sensors
         * perceives everything.
         */
        public Builder sensor(Sensor sensor) {
            if (sensors.stream().anyMatch(other -> other.name().equals(sensor.name()))) {
                throw new IllegalArgumentException(
                        "item " + name + " has two sensors named " + sensor.name());
            }
            sensors = Named.append(sensors, sensor);
            return this;
        }

        /** Sets the voice of an agent with the item as its body. */
        public Builder voice(Voice newVoice) {
            voice = Optional.of(newVoice);
            return this;
        }

        /**
         * Sets the levels. The definition describes the item at one of them, whose name is the
         * symbol {@link Level#SYMBOL}. If this level is a group, its parts are items of their own,
         * and the item is attached to the first part with a mass.
         */
        public Builder levels(List<Level> newLevels) {
            levels = List.copyOf(newLevels);
            return this;
        }

        /** Sets a numeric physics property, in its SI unit. */
        public Builder physics(String property, double... values) {
            Values.requireFinite(name, property, values);
            numbers = numbers.with(property, values.clone());
            return this;
        }

        /**
         * Sets several numeric physics properties by name, in the order of the map. This is faster
         * than single calls.
         */
        public Builder physics(Map<String, double[]> properties) {
            properties.forEach((property, values) -> Values.requireFinite(name, property, values));
            numbers = numbers.withAll(properties);
            return this;
        }

        /**
         * Sets a physics property that refers to items by name, such as {@code end1} or {@code
         * vertices}.
         */
        public Builder reference(String property, String... itemNames) {
            references = references.with(property, List.of(itemNames));
            return this;
        }

        /**
         * Returns the definition.
         *
         * @throws IllegalArgumentException if the item has a voice and an action {@code say}
         */
        public ItemDefinition build() {
            return new ItemDefinition(this);
        }
    }
}
