// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;

/**
 * The virtual world store: one {@link Table} of columns per kind for numbers, one immutable map for
 * what is symbolic. Here items come, go, change their names and move with each other; what they are
 * is changed through their aspects ({@link Item}).
 *
 * <p>One thread owns a world and all it hands out; the others read a {@link WorldSnapshot}. Its
 * {@link #guard()} says which thread that is and what may be changed now: items come and go only
 * while the structure is unlocked, not in PHYSICS, DERIVE and PUBLISH.
 */
public final class World {

    private final String name;
    private final WorldPrototype prototype;
    private final WorldGuard guard;
    private final Activity activity = new Activity();
    private final Layout layout;
    private final Map<String, Table> tableByKind = new HashMap<>();
    private final List<Table> tables;
    private final Register register = new Register();
    private final FrameRecord record = new FrameRecord();
    private final Hierarchy hierarchy;
    private final References references;
    private final Forces forces;
    private final Arrests arrests;
    private final Relations relations;
    private final Space space;
    private long boundsVersion;
    private long age;

    /**
     * An empty world but for the item {@code world}, whose physics aspect holds the world's
     * constants.
     *
     * @param name of letters a to z, digits, spaces, {@code .}, {@code _} and {@code -}, beginning
     *     with a letter or digit: it becomes part of file names
     * @param arena where column memory comes from; it must outlive the world, and the caller closes
     *     it
     */
    public World(String name, WorldPrototype prototype, ColumnArena arena) {
        this.name = Names.requireWorldName(name);
        this.prototype = prototype;
        guard = new WorldGuard(name);
        layout = new Layout(arena);
        tables = prototype.kinds().stream().map(kind -> new Table(this, kind, layout)).toList();
        tables.forEach(table -> tableByKind.put(table.kind(), table));
        hierarchy = new Hierarchy(table(WorldPrototype.BODY), activity);
        references = new References(tables, register);
        forces = new Forces(this);
        arrests = new Arrests(this);
        space = spaceOf(table(WorldPrototype.BODY));
        relations = new Relations(table(WorldPrototype.BODY), space, id -> item(id).name());
        var constants = ItemDefinition.named(WorldPrototype.WORLD).kind(WorldPrototype.WORLD);
        register.addAll(List.of(insert(constants.build(), true, null)));
    }

    public String name() {
        return name;
    }

    public WorldPrototype prototype() {
        return prototype;
    }

    /** Which thread owns the world, and what it may change now. */
    public WorldGuard guard() {
        return guard;
    }

    /** What the world's thread does now; any thread may ask. */
    public Activity activity() {
        return activity;
    }

    /**
     * Frames of simulated time that the world has behind it; with an older image they come back.
     */
    public long age() {
        guard.checkOwner();
        return age;
    }

    /** How old the world is when it begins; for whoever builds it. */
    public void setAge(long frames) {
        guard.checkOwner();
        age = frames;
    }

    /** Time goes on by a frame; told by who makes frames. */
    public void beginFrame() {
        guard.checkOwner();
        age++;
    }

    /** Adds one item; see {@link #addAll}. */
    public Item add(ItemDefinition definition) {
        return addAll(List.of(definition)).getFirst();
    }

    /**
     * Adds items, which may refer to each other in any order. All are added or, if any is refused,
     * none.
     *
     * @throws IllegalArgumentException naming item, property and value if a name is taken, a kind
     *     or property does not exist, a value does not fit, or a reference is missing or points at
     *     nothing, at the wrong kind or at scenery
     * @throws IllegalStateException naming the phase if the structure is locked
     */
    public List<Item> addAll(List<ItemDefinition> definitions) {
        return addAll(definitions, null);
    }

    /**
     * As the other one.
     *
     * @param maker the agent whose action creates them, null for none; see {@link #made}
     */
    public List<Item> addAll(List<ItemDefinition> definitions, @Nullable String maker) {
        guard.requireUnlocked("add items");
        new DefinitionCheck(this, definitions).run();
        makeRoom(definitions);
        var added = new ArrayList<Item>(definitions.size());
        for (ItemDefinition definition : definitions) {
            added.add(insert(definition, definition.hasPhysics(), maker));
        }
        register.addAll(added);
        for (int i = 0; i < added.size(); i++) {
            link(added.get(i), definitions.get(i));
        }
        hierarchy.placeNew(added);
        if (!added.isEmpty()) {
            record.note(
                    new WorldChange.Added(added.getFirst().id(), List.copyOf(definitions), maker));
        }
        return List.copyOf(added);
    }

    /** Throws as {@link #addAll} would now, and adds nothing. */
    public void requireAddable(List<ItemDefinition> definitions) {
        new DefinitionCheck(this, definitions).run();
    }

    /**
     * Removes an item.
     *
     * @throws IllegalArgumentException naming who refers to it, or if it is the item {@code world}
     * @throws IllegalStateException naming the phase if the structure is locked
     */
    public void remove(ItemId id) {
        Item item = removable(id);
        requireRemovable(id);
        delete(item);
        record.note(new WorldChange.Removed(id, item.name(), List.of()));
    }

    /** Throws as {@link #remove} would now for the item's sake, and removes nothing. */
    public void requireRemovable(ItemId id) {
        Item item = item(id);
        requireNotConstants(item, "it stays");
        if (item.referrers > 0 || item.children != null) {
            throw new IllegalArgumentException(
                    item
                            + " cannot be removed: "
                            + references.describeReferrers(item)
                            + " refers to it or is attached to it; "
                            + "remove that first, or remove in cascade");
        }
    }

    /**
     * Removes an item and, first, all items that refer to it or are attached to it, directly or
     * not; else as {@link #remove}.
     */
    public void removeCascade(ItemId id) {
        Item item = removable(id);
        List<Item> order = references.withReferrers(item).reversed();
        order.forEach(this::delete);
        List<ItemId> cascade = order.stream().filter(other -> other != item).map(Item::id).toList();
        record.note(new WorldChange.Removed(id, item.name(), cascade));
    }

    /**
     * Gives an item another name. References stay, as they are by id.
     *
     * @throws IllegalArgumentException if the name is taken or cannot be one
     * @throws IllegalStateException naming the phase if the structure is locked
     */
    public void rename(ItemId id, String newName) {
        Item item = item(id);
        if (!newName.equals(item.name())) {
            Names.requireItemName("new name of " + item, newName);
        }
        restoreName(id, newName);
    }

    /** As {@link #rename}, with whatever name a store kept. */
    public void restoreName(ItemId id, String newName) {
        guard.requireUnlocked("rename items");
        Item item = item(id);
        String oldName = item.name();
        if (newName.equals(oldName)) {
            return;
        }
        requireNotConstants(item, "its name is fixed");
        DefinitionCheck.requireFree(
                Names.require("new name of " + item, newName), register.find(newName) != null);
        setSymbols(item, item.symbols().renamed(newName));
        record.note(new WorldChange.Renamed(id, oldName, newName));
    }

    /** Throws as {@link #attach} would now for the items' sake, and attaches nothing. */
    public void requireAttachable(ItemId child, ItemId parent) {
        hierarchy.requireAttachable(item(child), item(parent));
    }

    /** As {@link #attach(ItemId, ItemId, Pose)}; the child stays where it is now. */
    public void attach(ItemId child, ItemId parent) {
        hierarchy.requireAttachable(item(child), item(parent));
        attach(child, parent, pose(child).relativeTo(pose(parent)));
    }

    /**
     * Makes a body move with another from now on, at a fixed pose in its frame. One that is
     * attached already changes its parent. Its place in the world frame follows in DERIVE, at any
     * depth.
     *
     * <p>Laws do not move what is attached: it is scenery or of mass 0, and forces on it do not
     * reach the parent.
     *
     * @throws IllegalArgumentException naming both if one is no body, the child has a mass, or the
     *     parent moves with the child
     * @throws IllegalStateException naming the phase if the structure is locked
     */
    public void attach(ItemId child, ItemId parent, Pose pose) {
        guard.requireUnlocked("attach items");
        Item item = item(child);
        hierarchy.requireAttachable(item, item(parent));
        Attachment before = item.symbols().attachment();
        setAttachment(item, item(parent), pose);
        hierarchy.settle(item);
        record.note(new WorldChange.Attached(child, before, item.attachment()));
    }

    /**
     * Lets an attached item be on its own, where it is now.
     *
     * @throws IllegalArgumentException if it is not attached
     * @throws IllegalStateException naming the phase if the structure is locked
     */
    public void detach(ItemId child) {
        guard.requireUnlocked("detach items");
        Item item = item(child);
        if (item.parent == null) {
            throw new IllegalArgumentException(item + " is not attached to anything");
        }
        Attachment before = item.attachment();
        hierarchy.settle(item);
        hierarchy.unlink(item);
        setSymbols(item, item.symbols().attached(null));
        record.note(new WorldChange.Detached(child, before));
    }

    /** Which bodies are where, as of the last DERIVE. */
    public Space space() {
        guard.checkOwner();
        return space;
    }

    /** How bodies are to each other, as of the last DERIVE. */
    public Relations relations() {
        guard.checkOwner();
        return relations;
    }

    /** The boxes around bodies were worked out anew; told in DERIVE. */
    public void boundsDerived() {
        guard.checkOwner();
        boundsVersion++;
    }

    private Space spaceOf(Table bodies) {
        return new Space(
                bodies.ids(),
                bodies.column("boundsMin"),
                bodies.column("boundsMax"),
                () -> {
                    guard.checkOwner();
                    return boundsVersion;
                },
                id -> register.find(new ItemId(id)) != null);
    }

    /** Puts what is attached where its parents are; in DERIVE, before anything looks. */
    public void placeAttached() {
        guard.checkOwner();
        hierarchy.place();
    }

    /**
     * Becomes, to the bit, the world that an image was copied from. Items of the same id stay the
     * same objects; those that the image does not have count as removed.
     *
     * @param image of a world of the same prototype
     * @throws IllegalArgumentException naming what differs if the prototype is another
     * @throws IllegalStateException naming the phase if the structure is locked
     */
    public void restore(WorldImage image) {
        guard.requireUnlocked("restore an image");
        for (int i = 0; i < tables.size(); i++) {
            image.tables().get(i).requireOf(tables.get(i));
        }
        register.restore(image, this::table);
        forces.restore(image.forces());
        for (int i = 0; i < tables.size(); i++) {
            tables.get(i).restore(image.tables().get(i), id -> item(new ItemId(id)));
        }
        references.countAll();
        hierarchy.restore(register.items());
        boundsVersion++;
        age = image.age();
        record.note(new WorldChange.Restored(image.frame()));
    }

    public Optional<Item> find(String itemName) {
        guard.checkOwner();
        return Optional.ofNullable(register.find(itemName));
    }

    /** The item of that id, as long as it is there. */
    public Optional<Item> find(ItemId id) {
        guard.checkOwner();
        return Optional.ofNullable(register.find(id));
    }

    /**
     * @throws IllegalArgumentException if there is no such item (any more)
     */
    public Item item(ItemId id) {
        guard.checkOwner();
        Item item = register.find(id);
        if (item == null) {
            throw new IllegalArgumentException("world " + name + " has no item " + id);
        }
        return item;
    }

    /**
     * Items whose symbol has a value, in the order of their ids; a copy. Looks them up in an index
     * that is kept current from the first time that the symbol is asked for.
     *
     * @param symbol a designer's or a standard one: {@code class}, {@code name}
     * @param value text, truth or a number
     */
    public List<Item> withSymbol(String symbol, Object value) {
        guard.checkOwner();
        return register.withSymbol(symbol, value);
    }

    /** All items in the order of their ids, the item {@code world} first; a copy. */
    public List<Item> items() {
        guard.checkOwner();
        return register.items();
    }

    /**
     * @throws IllegalArgumentException if the prototype has no such kind
     */
    public Table table(String kind) {
        Table table = tableByKind.get(kind);
        if (table == null) {
            throw new IllegalArgumentException(
                    "kind \"" + kind + "\" does not exist; kinds are " + prototype.kinds());
        }
        return table;
    }

    /** In the order of {@link WorldPrototype#kinds()}. */
    public List<Table> tables() {
        return tables;
    }

    /**
     * Raised whenever rows were added, removed or moved, or column memory was replaced. Replaced
     * memory stays readable until the next PHYSICS is over.
     */
    public long layoutVersion() {
        return layout.version();
    }

    /** What is symbolic about all items, in the order of their ids: one immutable version. */
    public PMap<ItemId, ItemSymbols> symbols() {
        guard.checkOwner();
        return register.symbols();
    }

    /**
     * Adds an event to the frame that is being made, or to the next one in PUBLISH and between
     * frames.
     */
    public void raise(WorldEvent event) {
        guard.requireEditable();
        record.raise(event);
    }

    /**
     * What became different in the frame that is being made, in the order it did, other than by
     * laws and in DERIVE; a copy. In PUBLISH it is the same to all who ask; changes made in PUBLISH
     * and between frames belong to the next frame, those made before the first to frame 0.
     */
    public List<WorldChange> changes() {
        guard.checkOwner();
        return record.changes();
    }

    /**
     * How many changes of the frame were too many to keep (2^20): what follows a world by its
     * changes then has to look at all of it.
     */
    public long changesLost() {
        guard.checkOwner();
        return record.changesLost();
    }

    /**
     * Events of the frame that is being made, in the order raised; a copy. In PUBLISH they are the
     * same to all who ask.
     */
    public List<WorldEvent> events() {
        guard.checkOwner();
        return record.events();
    }

    /** Forces on bodies that last for some frames. */
    public Forces forces() {
        return forces;
    }

    /** Items that laws may fail at because of what actions and edits did to them. */
    public Arrests arrests() {
        return arrests;
    }

    /**
     * Frees column memory that was replaced; called when PHYSICS is over, as all have rebound by
     * then.
     */
    public void releaseReplacedMemory() {
        guard.checkOwner();
        layout.releaseReplaced();
    }

    /** Begins PUBLISH: what is raised or changed from now on belongs to the next frame. */
    public void fixEvents() {
        guard.checkOwner();
        record.fix();
    }

    /** Ends a frame: forgets its events and changes, fixed or not, and unlocks the structure. */
    public void endFrame() {
        guard.checkOwner();
        record.end();
        guard.unlockStructure();
    }

    void note(WorldChange change) {
        record.note(change);
    }

    void noteEdited(Column column) {
        record.noteEdited(column);
    }

    Hierarchy hierarchy() {
        return hierarchy;
    }

    References references() {
        return references;
    }

    /** How many items there are that actions of an agent created. */
    public int made(String agent) {
        guard.checkOwner();
        return register.made(agent);
    }

    /** How many items there are that actions of agents created. */
    public int made() {
        guard.checkOwner();
        return register.made();
    }

    /** The highest id that was ever given to an item. */
    public long lastId() {
        return register.lastId();
    }

    @Nullable Item findItem(ItemId id) {
        return register.find(id);
    }

    @Nullable Item findItem(String itemName) {
        return register.find(itemName);
    }

    void setSymbols(Item item, ItemSymbols changed) {
        guard.requireEditable();
        register.setSymbols(item, changed);
    }

    void giveFirstPhysics(Item item) {
        guard.requireUnlocked("give " + item + " its first physics property");
        List<Column> needed = item.table().references();
        if (!needed.isEmpty()) {
            throw new IllegalArgumentException(
                    item
                            + " is scenery without "
                            + needed.getFirst().name()
                            + ": add it with its references instead");
        }
        item.table().promote(item);
    }

    void takePhysics(Item item) {
        guard.requireUnlocked("take " + item + " out of physics");
        requireNotConstants(item, "laws need them");
        if (item.referrers > 0) {
            throw new IllegalArgumentException(
                    item
                            + " cannot become scenery: "
                            + references.describeReferrers(item)
                            + " refers to it");
        }
        references.release(item);
        item.table().demote(item);
    }

    void setReferences(Item item, Column column, List<ItemId> targets) {
        guard.requireUnlocked("change " + column.name() + " of " + item);
        references.set(item, column, targets.stream().map(this::item).toList());
    }

    /** Reserves memory before anything is added, because only that can still fail. */
    private void makeRoom(List<ItemDefinition> definitions) {
        for (Table table : tables) {
            int more = 0;
            for (ItemDefinition definition : definitions) {
                more += definition.kind().equals(table.kind()) ? 1 : 0;
            }
            table.makeRoom(table.rowCount() + more);
        }
    }

    private Item insert(ItemDefinition definition, boolean physics, @Nullable String maker) {
        Table table = table(definition.kind());
        Item item = new Item(table, register.symbolsOf(definition, maker));
        table.insert(item, physics);
        if (!item.physical().isEmpty()) {
            item.physical().place(definition);
        }
        List<String> properties = definition.physicsProperties();
        for (int i = 0; i < properties.size(); i++) {
            table.physicsColumn(properties.get(i))
                    .write(item.row, definition.physicsValues().get(i));
        }
        return item;
    }

    /** Points an added item at those it refers to and moves with, which may be added with it. */
    private void link(Item item, ItemDefinition definition) {
        references.resolve(item, definition);
        definition
                .parent()
                .ifPresent(
                        parent ->
                                setAttachment(
                                        item,
                                        Objects.requireNonNull(register.find(parent)),
                                        Pose.exactly(
                                                definition.location(), definition.orientation())));
    }

    private void setAttachment(Item child, Item parent, Pose pose) {
        hierarchy.link(child, parent);
        setSymbols(child, child.symbols().attached(new Attachment(parent.id(), pose)));
    }

    private Pose pose(ItemId id) {
        return Pose.of(hierarchy.worldPose(item(id)));
    }

    private Item removable(ItemId id) {
        guard.requireUnlocked("remove items");
        Item item = item(id);
        requireNotConstants(item, "it stays");
        return item;
    }

    private static void requireNotConstants(Item item, String therefore) {
        if (item.kind().equals(WorldPrototype.WORLD)) {
            throw new IllegalArgumentException(item + " holds the world's constants; " + therefore);
        }
    }

    private void delete(Item item) {
        references.release(item);
        hierarchy.unlink(item);
        item.table().remove(item);
        register.remove(item);
    }
}
