package reve.core.world;

import java.lang.foreign.MemorySegment;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;
import org.pcollections.TreePMap;

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

    private final String name;
    private final WorldPrototype prototype;
    private final ColumnArena arena;
    private final Map<String, Table> tableByKind = new HashMap<>();
    private final List<Table> tables;
    private final Map<ItemId, Item> items = new LinkedHashMap<>();
    private final Map<String, Item> itemsByName = new HashMap<>();
    private final List<MemorySegment> retired = new ArrayList<>();
    private final List<WorldEvent> events = new ArrayList<>();
    private @Nullable List<WorldEvent> published;
    private PMap<ItemId, ItemSymbols> symbols = TreePMap.empty();
    private volatile Thread owner = Thread.currentThread();
    private @Nullable String lockedBy;
    private long lastId;
    private long layoutVersion;

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
        var constants = ItemDefinition.named(WorldPrototype.WORLD).kind(WorldPrototype.WORLD);
        insert(constants.build(), true);
    }

    public String name() {
        return name;
    }

    public WorldPrototype prototype() {
        return prototype;
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
        for (int i = 0; i < added.size(); i++) {
            resolveReferences(added.get(i), definitions.get(i));
        }
        return List.copyOf(added);
    }

    /**
     * Removes an item.
     *
     * @throws IllegalArgumentException naming who refers to it, or if it is the item {@code world}
     * @throws IllegalStateException naming the phase if the structure is locked
     */
    public void remove(ItemId id) {
        Item item = removable(id);
        if (item.referrers > 0) {
            Set<Item> referring = new LinkedHashSet<>();
            addReferrers(Set.of(item), referring);
            throw new IllegalArgumentException(item + " cannot be removed: "
                    + String.join(", ", referring.stream().map(Item::toString).limit(5).toList())
                    + (referring.size() > 5 ? ", ..." : "")
                    + " refers to it; remove that first, or remove in cascade");
        }
        delete(item);
    }

    /**
     * Removes an item and, first, all items that refer to it, directly or not; else as {@link
     * #remove}.
     */
    public void removeCascade(ItemId id) {
        Set<Item> doomed = new LinkedHashSet<>();
        doomed.add(removable(id));
        int before;
        do {
            before = doomed.size();
            addReferrers(Set.copyOf(doomed), doomed);
        } while (doomed.size() > before);
        new ArrayList<>(doomed).reversed().forEach(this::delete);
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
            requireSameColumns(tables.get(i), image.tables().get(i));
        }
        items.values().forEach(item -> item.row = Item.REMOVED);
        Map<ItemId, Item> restored = new LinkedHashMap<>();
        image.symbols().forEach((id, itemSymbols) -> restored.put(id, revive(itemSymbols)));
        items.clear();
        items.putAll(restored);
        itemsByName.clear();
        items.values().forEach(item -> itemsByName.put(item.name(), item));
        symbols = image.symbols();
        lastId = image.lastId();
        for (int i = 0; i < tables.size(); i++) {
            tables.get(i).restore(image.tables().get(i), id -> item(new ItemId(id)));
        }
        tables.forEach(this::countReferences);
        layoutVersion++;
    }

    public Optional<Item> find(String itemName) {
        checkOwner();
        return Optional.ofNullable(itemsByName.get(itemName));
    }

    /** @throws IllegalArgumentException if there is no such item (any more) */
    public Item item(ItemId id) {
        checkOwner();
        Item item = items.get(id);
        if (item == null) {
            throw new IllegalArgumentException("world " + name + " has no item " + id);
        }
        return item;
    }

    /** All items in the order of their ids, the item {@code world} first; a copy. */
    public List<Item> items() {
        checkOwner();
        return List.copyOf(items.values());
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
        return symbols;
    }

    /**
     * Adds an event to the frame that is being made, or to the next one in PUBLISH and between
     * frames.
     */
    public void raise(WorldEvent event) {
        checkOwner();
        events.add(event);
    }

    /**
     * Events of the frame that is being made, in the order raised; a copy. In PUBLISH they are the
     * same to all who ask.
     */
    public List<WorldEvent> events() {
        checkOwner();
        return published != null ? published : copyOfEvents();
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

    /** Begins PUBLISH: what is raised from now on belongs to the next frame. */
    public void fixEvents() {
        checkOwner();
        published = copyOfEvents();
        events.clear();
    }

    /** Ends a frame: forgets its events, fixed or not, and unlocks the structure. */
    public void endFrame() {
        checkOwner();
        if (published == null) {
            events.clear();
        }
        published = null;
        lockedBy = null;
    }

    /** Allocates only if there are events. */
    private List<WorldEvent> copyOfEvents() {
        return events.isEmpty() ? List.of() : List.copyOf(events);
    }

    long lastId() {
        return lastId;
    }

    void checkOwner() {
        if (CHECK_THREAD && Thread.currentThread() != owner) {
            throw new IllegalStateException("world " + name + " belongs to thread "
                    + owner.getName() + ", but " + Thread.currentThread().getName()
                    + " used it: read a snapshot, or claim() it when the owner has stopped");
        }
    }

    @Nullable Item findItem(ItemId id) {
        return items.get(id);
    }

    @Nullable Item findItem(String itemName) {
        return itemsByName.get(itemName);
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
        item.setSymbols(changed);
        symbols = symbols.plus(item.id(), changed);
    }

    void giveFirstPhysics(Item item) {
        requireUnlocked("give " + item + " its first physics property");
        List<Column> references = item.table().references();
        if (!references.isEmpty()) {
            throw new IllegalArgumentException(item + " is scenery without "
                    + references.getFirst().name() + ": add it with its references instead");
        }
        item.table().promote(item);
        layoutVersion++;
    }

    void setReferences(Item item, Column column, List<ItemId> targets) {
        requireUnlocked("change " + column.name() + " of " + item);
        String where = item + ": " + column.name();
        PropertyDescriptor property = column.descriptor();
        if (column.type() != ScalarType.REF || targets.size() != column.components()) {
            throw new IllegalArgumentException(where + " takes " + column.components() + " "
                    + column.type() + ", found " + targets.size() + " references");
        }
        for (ItemId target : targets) {
            Item other = item(target);
            DefinitionCheck.requireTarget(where, property, other.name(), other.kind(),
                    !other.physics().isEmpty());
        }
        for (int i = 0; i < targets.size(); i++) {
            count(column.getReference(item.row, i), -1);
            column.setReference(item.row, i, targets.get(i).value());
            count(targets.get(i).value(), 1);
        }
    }

    /** The item of that id and kind if it is there, else a new object; in no row yet. */
    private Item revive(ItemSymbols itemSymbols) {
        Item item = items.get(itemSymbols.id());
        if (item == null || !item.kind().equals(itemSymbols.kind())) {
            item = new Item(this, table(itemSymbols.kind()), itemSymbols);
        }
        item.setSymbols(itemSymbols);
        item.referrers = 0;
        return item;
    }

    private void countReferences(Table table) {
        for (Column column : table.references()) {
            for (int row = 0; row < table.physicsRowCount(); row++) {
                for (int i = 0; i < column.components(); i++) {
                    count(column.getReference(row, i), 1);
                }
            }
        }
    }

    private static void requireSameColumns(Table table, TableCopy copy) {
        List<PropertyDescriptor> expected =
                table.allColumns().stream().map(Column::descriptor).toList();
        if (!table.kind().equals(copy.kind()) || !expected.equals(copy.properties())) {
            throw new IllegalArgumentException("the image is of a world with another prototype: "
                    + "kind " + copy.kind() + " has the properties " + names(copy.properties())
                    + ", expected kind " + table.kind() + " with " + names(expected));
        }
    }

    private static List<String> names(List<PropertyDescriptor> properties) {
        return properties.stream().map(PropertyDescriptor::name).toList();
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
        var itemSymbols = new ItemSymbols(new ItemId(++lastId), definition);
        Item item = new Item(this, table, itemSymbols);
        table.insert(item, physics);
        items.put(item.id(), item);
        itemsByName.put(item.name(), item);
        setSymbols(item, itemSymbols);
        if (!item.physical().isEmpty()) {
            item.physical().place(definition);
        }
        for (String property : definition.physicsProperties()) {
            item.physics().set(property, definition.physics(property).orElseThrow());
        }
        layoutVersion++;
        return item;
    }

    private void resolveReferences(Item item, ItemDefinition definition) {
        definition.references().forEach((property, targetNames) -> {
            Column column = item.table().physicsColumn(property);
            for (int i = 0; i < targetNames.size(); i++) {
                Item target = itemsByName.get(targetNames.get(i));
                column.setReference(item.row, i, target.id().value());
                target.referrers++;
            }
        });
    }

    private Item removable(ItemId id) {
        requireUnlocked("remove items");
        Item item = item(id);
        if (item.kind().equals(WorldPrototype.WORLD)) {
            throw new IllegalArgumentException(item + " holds the world's constants; it stays");
        }
        return item;
    }

    private void delete(Item item) {
        if (!item.physics().isEmpty()) {
            for (Column column : item.table().references()) {
                for (int i = 0; i < column.components(); i++) {
                    count(column.getReference(item.row, i), -1);
                }
            }
        }
        item.table().remove(item);
        items.remove(item.id());
        itemsByName.remove(item.name());
        symbols = symbols.minus(item.id());
        layoutVersion++;
    }

    private void count(long target, int change) {
        Item item = items.get(new ItemId(target));
        if (item != null) {
            item.referrers += change;
        }
    }

    private void addReferrers(Set<Item> targets, Set<Item> into) {
        for (Table table : tables) {
            for (Column column : table.references()) {
                for (int row = 0; row < table.physicsRowCount(); row++) {
                    for (int i = 0; i < column.components(); i++) {
                        if (targets.contains(items.get(new ItemId(column.getReference(row, i))))) {
                            into.add(table.itemAt(row));
                        }
                    }
                }
            }
        }
    }

    private void requireUnlocked(String what) {
        checkOwner();
        if (lockedBy != null) {
            throw new IllegalStateException("cannot " + what + " of world " + name + " in phase "
                    + lockedBy + ": the structure changes in INTAKE, ACT or between frames only");
        }
    }
}
