package reve.core.world;

import java.lang.foreign.MemorySegment;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.Set;
import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;

/**
 * The virtual world store: one {@link Table} of columns per kind for numbers, one immutable map for
 * what is symbolic.
 *
 * <p>One thread owns a world: at first the one that made it, then the one that last called
 * {@link #claim()}; {@code FrameLoop} claims for whoever runs it. No other thread may touch it or
 * anything it hands out; they read a {@link WorldSnapshot}. With {@code -Dreve.check.thread=true}
 * this is checked.
 *
 * <p>Items come and go only while the structure is unlocked: not in PHYSICS, DERIVE and PUBLISH.
 */
public final class World {

    private static final boolean CHECK_THREAD = Boolean.getBoolean("reve.check.thread");

    /** Changes that a frame keeps; more are only counted. */
    public static final int MAX_CHANGES_PER_FRAME = 1 << 20;

    private final String name;
    private final WorldPrototype prototype;
    private final ColumnArena arena;
    private final Map<String, Table> tableByKind = new HashMap<>();
    private final List<Table> tables;
    private final Register register = new Register();
    private final List<MemorySegment> retired = new ArrayList<>();
    private final FrameLog<WorldEvent> events = new FrameLog<>(Integer.MAX_VALUE);
    private final FrameLog<WorldChange> changes = new FrameLog<>(MAX_CHANGES_PER_FRAME);
    private final List<Column> directlyEdited = new ArrayList<>();
    private final Hierarchy hierarchy;
    private final References references;
    private final Forces forces;
    private final Relations relations;
    private final Space space;
    private long boundsVersion;
    private volatile Thread owner = Thread.currentThread();
    private @Nullable String lockedBy;
    private @Nullable String inspectedBy;
    private long layoutVersion;
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
        this.arena = arena;
        tables = prototype.kinds().stream().map(kind -> new Table(this, kind)).toList();
        tables.forEach(table -> tableByKind.put(table.kind(), table));
        hierarchy = new Hierarchy(table(WorldPrototype.BODY));
        references = new References(tables, register);
        forces = new Forces(this);
        space = spaceOf(table(WorldPrototype.BODY));
        relations = new Relations(table(WorldPrototype.BODY), space, id -> item(id).name());
        var constants = ItemDefinition.named(WorldPrototype.WORLD).kind(WorldPrototype.WORLD);
        register.addAll(List.of(insert(constants.build(), true)));
    }

    public String name() {
        return name;
    }

    public WorldPrototype prototype() {
        return prototype;
    }

    /** Frames of simulated time that the world has behind it; with an older image they come back. */
    public long age() {
        checkOwner();
        return age;
    }

    /** How old the world is when it begins; for whoever builds it. */
    public void setAge(long frames) {
        checkOwner();
        age = frames;
    }

    /** Time goes on by a frame; told by who makes frames. */
    public void beginFrame() {
        checkOwner();
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
        requireUnlocked("add items");
        new DefinitionCheck(this, definitions).run();
        makeRoom(definitions);
        var added = new ArrayList<Item>(definitions.size());
        for (ItemDefinition definition : definitions) {
            added.add(insert(definition, definition.hasPhysics()));
        }
        register.addAll(added);
        layoutVersion++;
        for (int i = 0; i < added.size(); i++) {
            link(added.get(i), definitions.get(i));
        }
        hierarchy.placeNew(added);
        if (!added.isEmpty()) {
            changes.add(new WorldChange.Added(added.getFirst().id(), List.copyOf(definitions)));
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
        changes.add(new WorldChange.Removed(id, item.name(), List.of()));
    }

    /** Throws as {@link #remove} would now for the item's sake, and removes nothing. */
    public void requireRemovable(ItemId id) {
        Item item = item(id);
        requireNotConstants(item, "it stays");
        if (item.referrers > 0 || item.children != null) {
            throw new IllegalArgumentException(item + " cannot be removed: "
                    + references.describeReferrers(item) + " refers to it or is attached to it; "
                    + "remove that first, or remove in cascade");
        }
    }

    /**
     * Removes an item and, first, all items that refer to it or are attached to it, directly or
     * not; else as {@link #remove}.
     */
    public void removeCascade(ItemId id) {
        Set<Item> doomed = new LinkedHashSet<>();
        Item item = removable(id);
        doomed.add(item);
        Set<Item> latest = doomed;
        while (!latest.isEmpty()) {
            Set<Item> next = new LinkedHashSet<>();
            references.addReferrers(latest, next);
            next.removeAll(doomed);
            doomed.addAll(next);
            latest = next;
        }
        List<Item> order = new ArrayList<>(doomed).reversed();
        order.forEach(this::delete);
        List<ItemId> cascade = order.stream().filter(other -> other != item).map(Item::id)
                .toList();
        changes.add(new WorldChange.Removed(id, item.name(), cascade));
    }

    /**
     * Gives an item another name. References stay, as they are by id.
     *
     * @throws IllegalArgumentException if the name is taken or cannot be one
     * @throws IllegalStateException naming the phase if the structure is locked
     */
    public void rename(ItemId id, String newName) {
        requireUnlocked("rename items");
        Item item = item(id);
        String oldName = item.name();
        if (newName.equals(oldName)) {
            return;
        }
        requireNotConstants(item, "its name is fixed");
        DefinitionCheck.requireFree(Names.require("new name of " + item, newName),
                register.find(newName) != null);
        setSymbols(item, item.symbols().renamed(newName));
        changes.add(new WorldChange.Renamed(id, oldName, newName));
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
        requireUnlocked("attach items");
        Item item = item(child);
        hierarchy.requireAttachable(item, item(parent));
        Attachment before = item.symbols().attachment();
        setAttachment(item, item(parent), pose);
        hierarchy.settle(item);
        changes.add(new WorldChange.Attached(child, before, item.attachment()));
    }

    /**
     * Lets an attached item be on its own, where it is now.
     *
     * @throws IllegalArgumentException if it is not attached
     * @throws IllegalStateException naming the phase if the structure is locked
     */
    public void detach(ItemId child) {
        requireUnlocked("detach items");
        Item item = item(child);
        if (item.parent == null) {
            throw new IllegalArgumentException(item + " is not attached to anything");
        }
        Attachment before = item.attachment();
        hierarchy.settle(item);
        hierarchy.unlink(item);
        setSymbols(item, item.symbols().attached(null));
        changes.add(new WorldChange.Detached(child, before));
    }

    /** Which bodies are where, as of the last DERIVE. */
    public Space space() {
        checkOwner();
        return space;
    }

    /** How bodies are to each other, as of the last DERIVE. */
    public Relations relations() {
        checkOwner();
        return relations;
    }

    /** The boxes around bodies were worked out anew; told in DERIVE. */
    public void boundsDerived() {
        checkOwner();
        boundsVersion++;
    }

    private Space spaceOf(Table bodies) {
        return new Space(bodies.ids(), bodies.column("boundsMin"), bodies.column("boundsMax"),
                () -> {
                    checkOwner();
                    return boundsVersion;
                }, id -> register.find(new ItemId(id)) != null);
    }

    /** Puts what is attached where its parents are; in DERIVE, before anything looks. */
    public void placeAttached() {
        checkOwner();
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
        requireUnlocked("restore an image");
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
        changes.add(new WorldChange.Restored(image.frame()));
        layoutVersion++;
    }

    public Optional<Item> find(String itemName) {
        checkOwner();
        return Optional.ofNullable(register.find(itemName));
    }

    /** The item of that id, as long as it is there. */
    public Optional<Item> find(ItemId id) {
        checkOwner();
        return Optional.ofNullable(register.find(id));
    }

    /** @throws IllegalArgumentException if there is no such item (any more) */
    public Item item(ItemId id) {
        checkOwner();
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
        checkOwner();
        return register.withSymbol(symbol, value);
    }

    /** All items in the order of their ids, the item {@code world} first; a copy. */
    public List<Item> items() {
        checkOwner();
        return register.items();
    }

    /**
     * All items but {@code world}, so that adding them in this order to an empty world of the same
     * prototype gives each that takes part in physics the row that it has here: in the order of
     * their ids as far as the order of the rows allows.
     */
    public List<Item> itemsInOrderOfRows() {
        checkOwner();
        Map<Table, Integer> nextRow = new HashMap<>();
        List<Item> items = register.items();
        List<Item> ordered = new ArrayList<>(items.size());
        for (Item item : items) {
            if (item.kind().equals(WorldPrototype.WORLD)) {
                continue;
            }
            Table table = item.table();
            ordered.add(item.physics().isEmpty() ? item
                    : table.itemAt(nextRow.merge(table, 1, Integer::sum) - 1));
        }
        return ordered;
    }

    /** @throws IllegalArgumentException if the prototype has no such kind */
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
        return layoutVersion;
    }

    /** What is symbolic about all items, in the order of their ids: one immutable version. */
    public PMap<ItemId, ItemSymbols> symbols() {
        checkOwner();
        return register.symbols();
    }

    /**
     * Adds an event to the frame that is being made, or to the next one in PUBLISH and between
     * frames.
     */
    public void raise(WorldEvent event) {
        requireEditable();
        events.add(event);
    }

    /**
     * What became different in the frame that is being made, in the order it did, other than by
     * laws and in DERIVE; a copy. In PUBLISH it is the same to all who ask; changes made in PUBLISH
     * and between frames belong to the next frame, those made before the first to frame 0.
     */
    public List<WorldChange> changes() {
        checkOwner();
        return changes.entries();
    }

    /**
     * How many changes of the frame were too many to keep ({@link #MAX_CHANGES_PER_FRAME}): what
     * follows a world by its changes then has to look at all of it.
     */
    public long changesLost() {
        checkOwner();
        return changes.lost();
    }

    /**
     * Events of the frame that is being made, in the order raised; a copy. In PUBLISH they are the
     * same to all who ask.
     */
    public List<WorldEvent> events() {
        checkOwner();
        return events.entries();
    }

    /** Makes the calling thread the owner; the former owner must have stopped using the world. */
    public void claim() {
        owner = Thread.currentThread();
    }

    /**
     * Refuses structural changes until {@link #unlockStructure()}; the phase appears in messages.
     */
    public void lockStructure(String phase) {
        checkOwner();
        lockedBy = phase;
    }

    public void unlockStructure() {
        checkOwner();
        lockedBy = null;
    }

    /**
     * Lets somebody look at the world and change nothing: until he is done, every change is refused
     * with an IllegalStateException that names him.
     */
    public <T, E extends Exception> T inspect(String who, Inspection<T, E> inspection) throws E {
        checkOwner();
        String outer = inspectedBy;
        inspectedBy = who;
        try {
            return inspection.look();
        } finally {
            inspectedBy = outer;
        }
    }

    /** What is done by somebody who changes nothing. */
    public interface Inspection<T, E extends Exception> {
        T look() throws E;
    }

    /** Forces on bodies that last for some frames. */
    public Forces forces() {
        return forces;
    }

    /**
     * Frees column memory that was replaced; called when PHYSICS is over, as all have rebound by
     * then.
     */
    public void releaseReplacedMemory() {
        checkOwner();
        for (int i = 0; i < retired.size(); i++) {
            arena.release(retired.get(i));
        }
        retired.clear();
    }

    /** Begins PUBLISH: what is raised or changed from now on belongs to the next frame. */
    public void fixEvents() {
        checkOwner();
        events.fix();
        changes.fix();
        forgetDirectEdits();
    }

    /** Ends a frame: forgets its events and changes, fixed or not, and unlocks the structure. */
    public void endFrame() {
        checkOwner();
        if (!changes.isFixed()) {
            forgetDirectEdits();
        }
        events.end();
        changes.end();
        lockedBy = null;
    }

    private void forgetDirectEdits() {
        directlyEdited.forEach(Column::forgetEdit);
        directlyEdited.clear();
    }

    void note(WorldChange change) {
        changes.add(change);
    }

    void noteEdited(Column column) {
        directlyEdited.add(column);
        changes.add(new WorldChange.ColumnEdited(column.descriptor().kind(), column.name()));
    }

    Hierarchy hierarchy() {
        return hierarchy;
    }

    /** The highest id that was ever given to an item. */
    public long lastId() {
        return register.lastId();
    }

    void requireEditable() {
        checkOwner();
        if (inspectedBy != null) {
            throw new IllegalStateException(inspectedBy + " may look at world " + name
                    + ", but not change it");
        }
    }

    void checkOwner() {
        if (CHECK_THREAD && Thread.currentThread() != owner) {
            throw new IllegalStateException("world " + name + " belongs to thread "
                    + owner.getName() + ", but " + Thread.currentThread().getName()
                    + " used it: read a snapshot, or claim() it when the owner has stopped");
        }
    }

    @Nullable Item findItem(ItemId id) {
        return register.find(id);
    }

    @Nullable Item findItem(String itemName) {
        return register.find(itemName);
    }

    MemorySegment reserve(String columnName, long bytes) {
        return arena.reserve(columnName, bytes);
    }

    /** Keeps memory that a column left until all have let go of it, as the layout tells them to. */
    void retire(MemorySegment memory) {
        retired.add(memory);
        layoutVersion++;
    }

    void setSymbols(Item item, ItemSymbols changed) {
        requireEditable();
        register.setSymbols(item, changed);
    }

    void giveFirstPhysics(Item item) {
        requireUnlocked("give " + item + " its first physics property");
        List<Column> needed = item.table().references();
        if (!needed.isEmpty()) {
            throw new IllegalArgumentException(item + " is scenery without "
                    + needed.getFirst().name() + ": add it with its references instead");
        }
        item.table().promote(item);
        layoutVersion++;
    }

    void takePhysics(Item item) {
        requireUnlocked("take " + item + " out of physics");
        requireNotConstants(item, "laws need them");
        if (item.referrers > 0) {
            throw new IllegalArgumentException(item + " cannot become scenery: "
                    + references.describeReferrers(item) + " refers to it");
        }
        references.release(item);
        item.table().demote(item);
        layoutVersion++;
    }

    void setReferences(Item item, Column column, List<ItemId> targets) {
        requireUnlocked("change " + column.name() + " of " + item);
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

    private Item insert(ItemDefinition definition, boolean physics) {
        Table table = table(definition.kind());
        Item item = new Item(table, register.symbolsOf(definition));
        table.insert(item, physics);
        if (!item.physical().isEmpty()) {
            item.physical().place(definition);
        }
        List<String> properties = definition.physicsProperties();
        for (int i = 0; i < properties.size(); i++) {
            table.physicsColumn(properties.get(i)).write(item.row,
                    definition.physicsValues().get(i));
        }
        return item;
    }

    /** Points an added item at those it refers to and moves with, which may be added with it. */
    private void link(Item item, ItemDefinition definition) {
        references.resolve(item, definition);
        definition.parent().ifPresent(parent -> setAttachment(item,
                Objects.requireNonNull(register.find(parent)),
                Pose.exactly(definition.location(), definition.orientation())));
    }

    private void setAttachment(Item child, Item parent, Pose pose) {
        hierarchy.link(child, parent);
        setSymbols(child, child.symbols().attached(new Attachment(parent.id(), pose)));
    }

    private Pose pose(ItemId id) {
        return Pose.of(hierarchy.worldPose(item(id)));
    }

    private Item removable(ItemId id) {
        requireUnlocked("remove items");
        Item item = item(id);
        requireNotConstants(item, "it stays");
        return item;
    }

    private static void requireNotConstants(Item item, String therefore) {
        if (item.kind().equals(WorldPrototype.WORLD)) {
            throw new IllegalArgumentException(
                    item + " holds the world's constants; " + therefore);
        }
    }

    private void delete(Item item) {
        references.release(item);
        hierarchy.unlink(item);
        item.table().remove(item);
        register.remove(item);
        layoutVersion++;
    }

    private void requireUnlocked(String what) {
        requireEditable();
        if (lockedBy != null) {
            throw new IllegalStateException("cannot " + what + " of world " + name + " in phase "
                    + lockedBy + ": the structure changes in INTAKE, ACT or between frames only");
        }
    }
}
