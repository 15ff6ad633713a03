// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;
import java.util.Optional;

/**
 * One thing in a world. It holds no numbers: its aspects are views of its row in the columns.
 * World's thread only; a removed item refuses every use.
 */
public final class Item {

    private final WorldData world;
    private final Table table;
    private ItemSymbols symbols;

    /**
     * Where the item was when it was asked for its row last, and the version of the layout then.
     */
    private int row;

    private long layoutVersion = -1;

    Item(WorldData world, ItemSymbols symbols) {
        this.world = world;
        this.table = world.table(symbols.kind());
        this.symbols = symbols;
    }

    /** Stays the same as long as the item is in the world, and in its images. */
    public ItemId id() {
        return symbols.id();
    }

    /** Unique in the world. */
    public String name() {
        return symbols.name();
    }

    /** The kind whose table its row is in. */
    public String kind() {
        return symbols.kind();
    }

    /** The agent whose action created the item; empty for items that came otherwise. */
    public Optional<String> maker() {
        return Optional.ofNullable(symbols.maker());
    }

    /** Where the item is and what it looks like. */
    public PhysicalAspect physical() {
        return new PhysicalAspect(this);
    }

    /** What agents perceive of it. */
    public SemanticAspect semantic() {
        return new SemanticAspect(this);
    }

    /** What agents can do with it. */
    public AccessAspect access() {
        return new AccessAspect(this);
    }

    /** What an agent that has the item as its body perceives with; none for everything. */
    public List<Sensor> sensors() {
        return symbols.sensors();
    }

    /** What physics laws see of it; empty for scenery. */
    public PhysicsAspect physics() {
        return new PhysicsAspect(this);
    }

    /**
     * The item as it is now, to be written to a file; added to another world of the same prototype,
     * it is the same item to the bit. Properties of its physics aspect that are 0 are left out.
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

    /** The item that this one moves with; see {@link World#attach}. */
    public Optional<ItemId> parent() {
        checkedRow();
        return Optional.ofNullable(symbols.attachment()).map(Attachment::parent);
    }

    /** Items that move with this one, in the order of their ids; a copy. */
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

    /** Changes what is symbolic about the item. */
    void change(ItemSymbols changed) {
        world.setSymbols(symbols, changed);
        symbols = changed;
    }

    /** Takes over what is symbolic about the item in an image, as its world does. */
    void restore(ItemSymbols restored) {
        symbols = restored;
    }

    /** The current row, after checking thread and life. */
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
