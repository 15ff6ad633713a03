// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.Comparator;
import java.util.List;
import java.util.Optional;
import java.util.TreeSet;

/**
 * One thing in a world. It holds no numbers: its aspects are views of its row in the columns.
 * World's thread only; a removed item refuses every use.
 */
public final class Item {

    static final int REMOVED = -1;

    private final Table table;
    private ItemSymbols symbols;

    /** Where the item is now; kept by its table. */
    int row = REMOVED;

    /** How many references of other items point here; kept by the world. */
    int referrers;

    /** What the item moves with, and what moves with it; kept by the hierarchy. */
    @Nullable Item parent;

    @Nullable TreeSet<Item> children;

    Item(Table table, ItemSymbols symbols) {
        this.table = table;
        this.symbols = symbols;
    }

    public ItemId id() {
        return symbols.id();
    }

    public String name() {
        return symbols.name();
    }

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

    /** The item as it is now, to be written to a file or added to another world. */
    public ItemDefinition definition() {
        checkedRow();
        return ItemDefinition.of(this);
    }

    /** The item that this one moves with; see {@link World#attach}. */
    public Optional<Item> parent() {
        checkedRow();
        return Optional.ofNullable(parent);
    }

    /** Items that move with this one, in the order of their ids; a copy. */
    public List<Item> children() {
        checkedRow();
        return children == null ? List.of() : List.copyOf(children);
    }

    void addChild(Item child) {
        if (children == null) {
            children = new TreeSet<>(Comparator.comparing(Item::id));
        }
        children.add(child);
        child.parent = this;
    }

    void removeChild(Item child) {
        if (children != null) {
            children.remove(child);
            children = children.isEmpty() ? null : children;
        }
        child.parent = null;
    }

    /**
     * @throws IllegalStateException if the item is attached to nothing
     */
    Attachment attachment() {
        Attachment attachment = symbols.attachment();
        if (attachment == null) {
            throw new IllegalStateException(this + " is attached to nothing");
        }
        return attachment;
    }

    World world() {
        return table.world();
    }

    Table table() {
        return table;
    }

    ItemSymbols symbols() {
        return symbols;
    }

    void setSymbols(ItemSymbols newSymbols) {
        symbols = newSymbols;
    }

    /** The current row, after checking thread and life. */
    int checkedRow() {
        world().guard().checkOwner();
        if (row == REMOVED) {
            throw new IllegalStateException(this + " was removed from world " + world().name());
        }
        return row;
    }

    @Override
    public String toString() {
        return "item " + name() + " (" + kind() + " " + id() + ")";
    }
}
