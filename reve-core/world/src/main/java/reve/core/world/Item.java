// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;
import java.util.Optional;

/**
 * An item of a world, such as a body or a spring. This object stores no numbers, because its
 * aspects read and write the item's row in the columns. For the world's thread only. A removed item
 * refuses every use.
 */
public final class Item {

    private final WorldData world;
    private final Table table;
    private ItemSymbols symbols;

    /** Cached row of the item. It is valid for one layout version, which the next field stores. */
    private int row;

    private long layoutVersion = -1;

    Item(WorldData world, ItemSymbols symbols) {
        this.world = world;
        this.table = world.table(symbols.kind());
        this.symbols = symbols;
    }

    /** Returns the id. It never changes, and saved images of the world contain it. */
    public ItemId id() {
        return symbols.id();
    }

    /** Returns the name, unique in the world. */
    public String name() {
        return symbols.name();
    }

    /**
     * Returns the kind, for example {@code body}. The table of this kind contains the item's row.
     */
    public String kind() {
        return symbols.kind();
    }

    /** Returns the agent whose action created the item; empty for other items. */
    public Optional<String> maker() {
        return Optional.ofNullable(symbols.maker());
    }

    /** Returns the physical aspect: place, shape and appearance. */
    public PhysicalAspect physical() {
        return new PhysicalAspect(this);
    }

    /** Returns the semantic aspect: symbols that agents perceive. */
    public SemanticAspect semantic() {
        return new SemanticAspect(this);
    }

    /** Returns the access aspect: actions and capabilities. */
    public AccessAspect access() {
        return new AccessAspect(this);
    }

    /**
     * Returns the sensors for an agent with this item as its body. The agent perceives everything
     * if the item has no sensors.
     */
    public List<Sensor> sensors() {
        return symbols.sensors();
    }

    /** Returns the voice of an agent with this item as its body; empty if it cannot speak. */
    public Optional<Voice> voice() {
        return symbols.voice();
    }

    /** Returns the levels of the item, see {@link Level}; empty for most items. */
    public List<Level> levels() {
        return symbols.levels();
    }

    /** Returns the active level; empty if the item has no levels. */
    public Optional<Level> level() {
        return levels().stream()
                .filter(level -> level.name().equals(symbols.given().get(Level.SYMBOL)))
                .findFirst();
    }

    /** Returns whether a symbol contains the name of the active level. */
    public boolean isLevel(String symbol) {
        return symbol.equals(Level.SYMBOL) && !levels().isEmpty();
    }

    /**
     * Returns the physics aspect, which contains the numbers that laws use. It is empty for
     * scenery, which laws do not move.
     */
    public PhysicsAspect physics() {
        return new PhysicsAspect(this);
    }

    /**
     * Returns a definition of the item in its current state, for a file. Another world of the same
     * prototype can create an item from the definition, and this item has the same bits. The
     * definition omits physics properties that are 0.
     */
    public ItemDefinition definition() {
        checkedRow();
        ItemDefinition.Builder now = ItemDefinition.kept(name()).kind(kind());
        if (!physical().isEmpty()) {
            now.placed = true;
            now.shape = physical().shape();
            now.material = physical().material();
            now.colour = physical().colour();
            now.location = physical().location();
            now.orientation = physical().orientation();
        }
        now.look = symbols.look();
        Attachment attachment = symbols.attachment();
        if (attachment != null) {
            now.parent = world.symbols.name(attachment.parent());
            now.location = attachment.pose().location();
            now.orientation = attachment.pose().orientation();
        }
        now.symbols = symbols.given();
        now.actions = symbols.actions();
        now.capabilities = symbols.capabilities();
        now.sensors = symbols.sensors();
        now.voice = symbols.voice();
        now.levels = symbols.levels();
        for (String property : physics().properties()) {
            if (table.physicsColumn(property).type() == ScalarType.REF) {
                List<ItemId> targets = physics().references(property);
                now.references =
                        now.references.with(
                                property, targets.stream().map(world.symbols::name).toList());
            } else if (!Values.isZero(physics().vector(property))) {
                now.numbers = now.numbers.with(property, physics().vector(property));
            }
        }
        if (now.numbers.isEmpty() && now.references.isEmpty() && !physics().isEmpty()) {
            String first = physics().properties().iterator().next();
            now.numbers = now.numbers.with(first, physics().vector(first));
        }
        return now.build();
    }

    /** Returns the parent; see {@link World#attach}. */
    public Optional<ItemId> parent() {
        checkedRow();
        return Optional.ofNullable(symbols.attachment()).map(Attachment::parent);
    }

    /** Returns a copy of the ids of the attached items, in ascending order. */
    public List<ItemId> children() {
        checkedRow();
        return world.hierarchy.children(id());
    }

    WorldData world() {
        return world;
    }

    Table table() {
        return table;
    }

    ItemSymbols symbols() {
        return symbols;
    }

    /** Replaces the symbolic data of the item. */
    void change(ItemSymbols changed) {
        world.setSymbols(symbols, changed);
        symbols = changed;
    }

    /**
     * Replaces the symbolic data of the item by that of an image to which the world is restored.
     */
    void restore(ItemSymbols restored) {
        symbols = restored;
    }

    /** Returns the current row, after a check of the thread and of the item's existence. */
    int checkedRow() {
        world.guard.checkOwner();
        if (layoutVersion != world.layout.version()) {
            layoutVersion = world.layout.version();
            row = table.rowOf(id());
        }
        if (row < 0) {
            throw new IllegalStateException(this + " was removed from world " + world.name);
        }
        return row;
    }

    @Override
    public String toString() {
        return symbols.label();
    }
}
