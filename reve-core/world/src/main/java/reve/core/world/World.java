// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.Set;

/**
 * The virtual world store. It contains one {@link Table} of columns per kind for numbers, and one
 * immutable map for symbolic data. This class adds, removes, renames and attaches items. Aspects
 * change the data of an item, see {@link Item}.
 *
 * <p>One thread owns a world and all objects that it returns. Other threads read a {@link
 * WorldSnapshot}. The {@link #guard()} checks the calling thread and whether a change is permitted.
 * Items may be added and removed only outside the phases PHYSICS, DERIVE and PUBLISH of a frame.
 */
public final class World {

    private final WorldData data;
    private final Items items = new Items();
    private final Forces forces;
    private final Arrests arrests;
    private final FrameControl frameControl;

    /**
     * Creates a world with only the item {@code world}, whose physics aspect contains the world's
     * constants.
     *
     * @param name letters a to z, digits, spaces, {@code .}, {@code _} and {@code -}, beginning
     *     with a letter or digit, because the name becomes part of file names
     * @param arena allocator of column memory; it must outlive the world, and the caller closes it
     */
    public World(String name, WorldPrototype prototype, ColumnArena arena) {
        data = new WorldData(Names.requireWorldName(name), prototype, arena);
        forces = new Forces(table(WorldPrototype.BODY), data.guard, data.record);
        arrests = new Arrests(items, data.guard);
        frameControl = new FrameControl(data, forces, items);
        var constants = ItemDefinition.named(WorldPrototype.WORLD).kind(WorldPrototype.WORLD);
        register(List.of(insert(constants.build(), true, null)));
    }

    /** Returns the name of the world, for messages and clients. */
    public String name() {
        return data.name;
    }

    /** Returns the prototype: the properties of the world's items. */
    public WorldPrototype prototype() {
        return data.prototype;
    }

    /** Returns the guard of threads and phases. */
    public WorldGuard guard() {
        return data.guard;
    }

    /**
     * Returns the activity, which describes the evaluation with which the world's thread is busy.
     * For any thread.
     */
    public Activity activity() {
        return data.activity;
    }

    /**
     * Returns the number of frames that led to the present state. The restoration of an image also
     * restores this number.
     */
    public long age() {
        data.guard.checkOwner();
        return data.age;
    }

    /** Sets the initial age of the world [frames]. Called while the world is built. */
    public void setAge(long frames) {
        data.guard.checkOwner();
        data.age = frames;
    }

    /** Adds one item; see {@link #addAll}. */
    public Item add(ItemDefinition definition) {
        return addAll(List.of(definition)).getFirst();
    }

    /**
     * Adds items, which may refer to each other in any order. Either all items are added or, if one
     * is refused, none.
     *
     * @throws IllegalArgumentException naming item, property and value if a name is taken, a kind
     *     or property does not exist, a value does not fit, or a reference is missing, or refers to
     *     no item, to the wrong kind or to an item without physics
     * @throws IllegalStateException naming the phase of the frame if it forbids structural changes
     */
    public List<Item> addAll(List<ItemDefinition> definitions) {
        return addAll(definitions, null);
    }

    /**
     * Adds items like {@link #addAll(List)}.
     *
     * @param maker the agent whose action creates the items, null for none; see {@link #made}
     */
    public List<Item> addAll(List<ItemDefinition> definitions, @Nullable String maker) {
        data.guard.requireUnlocked("add items");
        new DefinitionCheck(data, items, definitions).run();
        makeRoom(definitions);
        var added = new ArrayList<Item>(definitions.size());
        for (ItemDefinition definition : definitions) {
            added.add(insert(definition, definition.hasPhysics(), maker));
        }
        register(added);
        for (int i = 0; i < added.size(); i++) {
            link(added.get(i), definitions.get(i));
        }
        data.hierarchy.placeNew(added.stream().map(Item::id).toList());
        if (!added.isEmpty()) {
            data.note(
                    new WorldChange.Added(added.getFirst().id(), List.copyOf(definitions), maker));
        }
        return List.copyOf(added);
    }

    /**
     * Checks whether items can be added, and adds nothing. Throws an exception if {@link #addAll}
     * would throw one now.
     */
    public void requireAddable(List<ItemDefinition> definitions) {
        new DefinitionCheck(data, items, definitions).run();
    }

    /**
     * Removes an item.
     *
     * @throws IllegalArgumentException naming the items that refer to the item, or if it is the
     *     item {@code world}
     * @throws IllegalStateException naming the phase of the frame if it forbids structural changes
     */
    public void remove(ItemId id) {
        Item item = removable(id);
        requireRemovable(id);
        delete(item);
        data.note(new WorldChange.Removed(id, item.name(), List.of()));
    }

    /**
     * Checks whether an item can be removed, and removes nothing. Throws an exception if {@link
     * #remove} would refuse the item now.
     */
    public void requireRemovable(ItemId id) {
        Item item = item(id);
        WorldData.requireNotConstants(item.symbols(), "it stays");
        if (isHeld(id)) {
            throw new IllegalArgumentException(
                    item
                            + " cannot be removed: "
                            + data.describeReferrers(id)
                            + " refers to it or is attached to it; "
                            + "remove that first, or remove in cascade");
        }
    }

    /**
     * Removes an item. First removes all items that refer to it or are attached to it, directly or
     * through other items. The method is otherwise like {@link #remove}.
     */
    public void removeCascade(ItemId id) {
        Item item = removable(id);
        List<ItemId> order = data.references.withReferrers(id).reversed();
        order.forEach(other -> delete(item(other)));
        List<ItemId> cascade = order.stream().filter(other -> !other.equals(id)).toList();
        data.note(new WorldChange.Removed(id, item.name(), cascade));
    }

    /**
     * Renames an item. References are not affected, because they contain ids.
     *
     * @throws IllegalArgumentException if the name is taken or invalid
     * @throws IllegalStateException naming the phase of the frame if it forbids structural changes
     */
    public void rename(ItemId id, String newName) {
        Item item = item(id);
        if (!newName.equals(item.name())) {
            Names.requireItemName("new name of " + item, newName);
        }
        restoreName(id, newName);
    }

    /**
     * Renames an item like {@link #rename}. The new name comes from a store and is not checked
     * again.
     */
    public void restoreName(ItemId id, String newName) {
        data.guard.requireUnlocked("rename items");
        Item item = item(id);
        String oldName = item.name();
        if (newName.equals(oldName)) {
            return;
        }
        WorldData.requireNotConstants(item.symbols(), "its name is fixed");
        DefinitionCheck.requireFree(
                Names.require("new name of " + item, newName), items.find(newName) != null);
        items.rename(item, item.symbols().renamed(newName));
        data.note(new WorldChange.Renamed(id, oldName, newName));
    }

    /**
     * Checks whether items can be attached, and attaches nothing. Throws an exception if {@link
     * #attach} would refuse the items now.
     */
    public void requireAttachable(ItemId child, ItemId parent) {
        data.hierarchy.requireAttachable(item(child).symbols(), item(parent).symbols());
    }

    /**
     * Attaches an item like {@link #attach(ItemId, ItemId, Pose)}. The child keeps its present pose
     * in the world.
     */
    public void attach(ItemId child, ItemId parent) {
        requireAttachable(child, parent);
        attach(child, parent, pose(child).relativeTo(pose(parent)));
    }

    /**
     * Attaches a body to a parent, with a fixed pose relative to the parent. A body that is already
     * attached gets a new parent. Attached bodies may be parents of other bodies. The phase DERIVE
     * computes their poses in the world's reference frame.
     *
     * <p>Laws do not move attached items, because attached items are scenery or have mass 0. Forces
     * on attached items do not act on the parent.
     *
     * @throws IllegalArgumentException naming both items if one is not a body, the child has a
     *     mass, or the parent is attached to the child, directly or through other items
     * @throws IllegalStateException naming the phase of the frame if it forbids structural changes
     */
    public void attach(ItemId child, ItemId parent, Pose pose) {
        data.guard.requireUnlocked("attach items");
        requireAttachable(child, parent);
        Item item = item(child);
        Attachment before = item.symbols().attachment();
        var attachment = new Attachment(parent, pose);
        attach(item, attachment);
        data.hierarchy.settle(child);
        data.note(new WorldChange.Attached(child, before, attachment));
    }

    /**
     * Detaches an item, which keeps its present pose in the world.
     *
     * @throws IllegalArgumentException if it is not attached
     * @throws IllegalStateException naming the phase of the frame if it forbids structural changes
     */
    public void detach(ItemId child) {
        data.guard.requireUnlocked("detach items");
        Item item = item(child);
        Attachment before = item.symbols().attachment();
        if (before == null) {
            throw new IllegalArgumentException(item + " is not attached to anything");
        }
        data.hierarchy.settle(child);
        data.hierarchy.detach(child);
        item.change(item.symbols().attached(null));
        data.note(new WorldChange.Detached(child, before));
    }

    /** Returns the spatial search, which uses the boxes of the last DERIVE phase. */
    public Space space() {
        data.guard.checkOwner();
        return data.space;
    }

    /** Returns the spatial relations between bodies, from the boxes of the last DERIVE phase. */
    public Relations relations() {
        data.guard.checkOwner();
        return data.relations;
    }

    /**
     * Restores the state of the world that an image contains, with the same bits. An {@link Item}
     * object stays valid if its id is in the image. The objects of other items count as removed
     * items.
     *
     * @param image image of a world of the same prototype
     * @throws IllegalArgumentException naming the difference if the image has another prototype
     * @throws IllegalStateException naming the phase of the frame if it forbids structural changes
     */
    public void restore(WorldImage image) {
        data.guard.requireUnlocked("restore an image");
        for (int i = 0; i < data.tables.size(); i++) {
            image.tables().get(i).requireOf(data.tables.get(i));
        }
        data.symbols.restore(image.symbols(), image.lastId());
        items.restore(image.symbols().values(), symbols -> new Item(data, symbols));
        forces.restore(image.forces());
        for (int i = 0; i < data.tables.size(); i++) {
            data.tables
                    .get(i)
                    .restore(image.tables().get(i), id -> image.symbols().get(id).shape());
        }
        data.references.countAll();
        data.hierarchy.restore(image.symbols().values());
        data.boundsChanged();
        data.age = image.age();
        data.note(new WorldChange.Restored(image.frame()));
    }

    /** Returns the item of that name. */
    public Optional<Item> find(String itemName) {
        data.guard.checkOwner();
        return Optional.ofNullable(items.find(itemName));
    }

    /** Returns the item of that id, if it is in the world. */
    public Optional<Item> find(ItemId id) {
        data.guard.checkOwner();
        return Optional.ofNullable(items.find(id));
    }

    /**
     * Returns the item of an id.
     *
     * @throws IllegalArgumentException if the item is not in the world
     */
    public Item item(ItemId id) {
        data.guard.checkOwner();
        Item item = items.find(id);
        if (item == null) {
            throw new IllegalArgumentException("world " + data.name + " has no item " + id);
        }
        return item;
    }

    /**
     * Returns a copy of the items whose symbol has a value, in the order of their ids. The first
     * search for a symbol builds an index, which the world keeps up to date.
     *
     * @param symbol a symbol of the designer, or the standard symbol {@code class}, {@code name} or
     *     {@code classes}; {@code classes} finds the items of a class and of all classes below it
     * @param value a text, a truth value or a number
     */
    public List<Item> withSymbol(String symbol, Object value) {
        data.guard.checkOwner();
        return items.of(data.symbols.with(symbol, value));
    }

    /** Returns the number of items, including the item {@code world}. */
    public int itemCount() {
        data.guard.checkOwner();
        return data.symbols.all().size();
    }

    /**
     * Returns a copy of all items in the order of their ids. The first one is the item {@code
     * world}.
     */
    public List<Item> items() {
        data.guard.checkOwner();
        return items.of(data.symbols.all().keySet());
    }

    /**
     * Returns the table of a kind.
     *
     * @throws IllegalArgumentException if the prototype has no such kind
     */
    public Table table(String kind) {
        return data.table(kind);
    }

    /** Returns the tables in the order of {@link WorldPrototype#kinds()}. */
    public List<Table> tables() {
        return data.tables;
    }

    /**
     * Returns the layout version. It increases on these occasions:
     *
     * <ul>
     *   <li>rows are added, removed or moved
     *   <li>items are attached or detached
     *   <li>column memory is replaced
     * </ul>
     *
     * <p>Replaced memory stays readable until the end of the next PHYSICS phase.
     */
    public long layoutVersion() {
        return data.layout.version();
    }

    /**
     * Returns the symbolic data of all items, in the order of their ids. The map is immutable, so
     * later changes of the world do not affect it.
     */
    public PMap<ItemId, ItemSymbols> symbols() {
        data.guard.checkOwner();
        return data.symbols.all();
    }

    /**
     * Adds an event to the frame that is being made. Events that are raised in the phase PUBLISH or
     * between frames belong to the next frame.
     *
     * @throws IllegalArgumentException if a listener of a plugin raises an event of a type in
     *     {@link WorldEvent#OF_THE_SERVER}
     */
    public void raise(WorldEvent event) {
        providerFaults().requireOwn(event);
        raiseOwn(event);
    }

    /** Adds an event of the server, like {@link #raise}. */
    void raiseOwn(WorldEvent event) {
        data.guard.requireEditable();
        data.record.raise(event);
    }

    /**
     * Returns a copy of the changes of the frame that is being made, in order. Omits changes by
     * laws and changes in the phase DERIVE. All callers receive the same changes in the phase
     * PUBLISH.
     *
     * <p>Changes made in PUBLISH and between frames belong to the next frame. Changes made before
     * the first frame belong to frame 0.
     */
    public List<WorldChange> changes() {
        data.guard.checkOwner();
        return data.record.changes();
    }

    /**
     * Returns the number of changes of the frame that exceeded the limit (2^20) and were not
     * stored. A listener that follows a world by its changes must read the whole world if this
     * number is not 0.
     */
    public long changesLost() {
        data.guard.checkOwner();
        return data.record.changesLost();
    }

    /**
     * Returns a copy of the events of the frame that is being made, in the order in which they were
     * raised. All callers receive the same events in the phase PUBLISH.
     */
    public List<WorldEvent> events() {
        data.guard.checkOwner();
        return data.record.events();
    }

    /**
     * Returns the reporter of failures in the code of providers, such as actions and listeners in
     * Java. For the world's thread only.
     */
    public ProviderFaults providerFaults() {
        return data.providerFaults;
    }

    /** Returns the readings of {@link FrameControl#setReadings}. */
    Map<ItemId, Map<String, double[]>> readings() {
        return data.readings;
    }

    /** Returns the forces that actions exert on bodies for a number of frames. */
    public Forces forces() {
        return forces;
    }

    /**
     * Returns the record of the items whose numbers were changed by actions and edits. Such numbers
     * may make laws fail.
     */
    public Arrests arrests() {
        return arrests;
    }

    /** Returns the account of the evaluation steps of rules that are charged to agents. */
    public Charges charges() {
        data.guard.checkOwner();
        return data.record.charges();
    }

    FrameControl frameControl() {
        return frameControl;
    }

    /**
     * Returns the items that refer to an item, directly or through other items. Equal worlds give
     * the same order.
     */
    List<Item> referring(ItemId id) {
        return items.of(data.references.referring(id));
    }

    /** Returns the items that refer to one of the items or are attached to one of them. */
    Set<ItemId> holding(List<ItemId> ids) {
        return data.references.holding(ids);
    }

    /** Returns whether other items refer to an item or are attached to it. */
    boolean isHeld(ItemId id) {
        return data.references.isReferredTo(id) || !data.hierarchy.children(id).isEmpty();
    }

    /** Returns the number of existing items that actions of this agent created. */
    public int made(String agent) {
        data.guard.checkOwner();
        return data.symbols.made(agent);
    }

    /** Returns the number of existing items that actions of all agents created. */
    public int made() {
        data.guard.checkOwner();
        return data.symbols.made();
    }

    /** Returns the size of the designer's symbols of all items, see {@link SymbolBytes}. */
    public long symbolBytes() {
        data.guard.checkOwner();
        return data.symbols.bytes();
    }

    /** Returns the highest id that was ever assigned to an item. */
    public long lastId() {
        return data.symbols.lastId();
    }

    private void register(List<Item> added) {
        added.forEach(item -> data.symbols.add(item.symbols()));
        items.addAll(added);
    }

    /** Allocates all memory before any item is added, so that adding cannot fail halfway. */
    private void makeRoom(List<ItemDefinition> definitions) {
        for (Table table : data.tables) {
            int more = 0;
            for (ItemDefinition definition : definitions) {
                more += definition.kind().equals(table.kind()) ? 1 : 0;
            }
            table.makeRoom(table.rowCount() + more);
        }
    }

    private Item insert(ItemDefinition definition, boolean physics, @Nullable String maker) {
        Table table = table(definition.kind());
        ItemSymbols symbols = data.symbols.create(definition, maker);
        int row = table.insert(symbols.id(), physics);
        Item item = new Item(data, symbols);
        if (!item.physical().isEmpty()) {
            item.physical().place(definition);
        }
        List<String> properties = definition.physicsProperties();
        for (int i = 0; i < properties.size(); i++) {
            table.physicsColumn(properties.get(i)).write(row, definition.physicsValues().get(i));
        }
        return item;
    }

    /**
     * Sets the references and the parent of an added item. The items to which it refers may have
     * been added together with it.
     */
    private void link(Item item, ItemDefinition definition) {
        if (definition.hasReferences()) {
            definition.references().forEach((property, names) -> refer(item, property, names));
        }
        if (definition.parent().isPresent()) {
            Item parent = Objects.requireNonNull(items.find(definition.parent().get()));
            Pose pose = Pose.exactly(definition.location(), definition.orientation());
            attach(item, new Attachment(parent.id(), pose));
        }
    }

    private void refer(Item item, String property, List<String> targets) {
        Column column = item.table().physicsColumn(property);
        for (int i = 0; i < targets.size(); i++) {
            Item target = Objects.requireNonNull(items.find(targets.get(i)));
            data.references.set(column, item.checkedRow(), i, target.id());
        }
    }

    private void attach(Item child, Attachment attachment) {
        data.hierarchy.attach(child.id(), attachment);
        child.change(child.symbols().attached(attachment));
    }

    private Pose pose(ItemId id) {
        return Pose.of(data.hierarchy.worldPose(item(id).id()));
    }

    private Item removable(ItemId id) {
        data.guard.requireUnlocked("remove items");
        Item item = item(id);
        WorldData.requireNotConstants(item.symbols(), "it stays");
        return item;
    }

    private void delete(Item item) {
        data.references.release(item.table(), item.id());
        data.hierarchy.detach(item.id());
        item.table().remove(item.id());
        items.remove(item);
        data.symbols.remove(item.symbols());
    }
}
