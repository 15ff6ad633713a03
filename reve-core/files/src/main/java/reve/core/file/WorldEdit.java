// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import org.jspecify.annotations.Nullable;

import reve.core.world.Action;
import reve.core.world.ActionRefused;
import reve.core.world.ConnectionLook;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.Level;
import reve.core.world.LevelChange;
import reve.core.world.OffHeapArena;
import reve.core.world.Possible;
import reve.core.world.PropertyDescriptor;
import reve.core.world.SymbolBytes;
import reve.core.world.World;
import reve.core.world.WorldImage;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.Collection;
import java.util.HashMap;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/**
 * A change of a running world's items that an operator requests. Its values have the form of world
 * files, and {@link EditReader} reads them. Immutable.
 */
public sealed interface WorldEdit {
    /** Maximum number of parts of the items whose levels one message changes. */
    int MAX_PARTS_OF_LEVELS = 10_000;

    /** The code with which the world refuses an edit, for programs. */
    String REFUSED = "edit-refused";

    /**
     * Adds items, which may refer to each other and to items of the world. Omits rows of substances
     * that the world has already.
     */
    record Add(List<ItemDefinition> items) implements WorldEdit {
        /** Copies the list. */
        public Add {
            items = List.copyOf(items);
        }
    }

    /**
     * Removes an item. Also removes all items that refer to it or are attached to it if {@code
     * cascade} is true.
     */
    record Remove(String item, boolean cascade) implements WorldEdit {}

    /**
     * Changes an item.
     *
     * @param item name of the item
     * @param values the new values, in the form of an item
     * @param set names of the values that change, in the order of the message: {@code name}, {@code
     *     parent}, {@code physical.shape}, {@code physics.mass}, {@code semantic.SYMBOL}, {@code
     *     access.ACTION}
     * @param cleared names of the values that the item loses: {@code parent}, {@code physics},
     *     {@code physical.material}, {@code semantic.SYMBOL}, {@code access.ACTION}
     */
    record Change(String item, ItemDefinition values, List<String> set, List<String> cleared)
            implements WorldEdit {
        /** Copies the lists. */
        public Change {
            set = List.copyOf(set);
            cleared = List.copyOf(cleared);
        }
    }

    /**
     * Makes edits in their order, either all of them or none. First tries several edits on a copy
     * of the world, which takes two bulk copies of the columns. For the world's thread, outside the
     * phase PHYSICS.
     *
     * @param frame number of the frame, for events
     * @param kept ids of items that no edit may remove, such as the bodies of agents
     * @param between called after the check that the edits are possible, and before they are made;
     *     if it throws an exception, the edits are refused
     * @throws ActionRefused with the reason; the world is then unchanged
     */
    static void make(
            World world, long frame, List<WorldEdit> edits, Collection<ItemId> kept, Step between)
            throws ActionRefused {
        SymbolBytes.require(world, symbolGrowth(world, edits), REFUSED);
        if (edits.size() != 1 || hasParts(edits.getFirst())) {
            tryOut(world, frame, edits, kept);
        } else if (edits.getFirst() instanceof Remove remove) {
            requireNotKept(find(world, remove.item), kept);
        }
        between.run();
        for (WorldEdit edit : edits) {
            make(world, frame, edit);
        }
    }

    /** Returns by how much edits enlarge the symbols of the world at most [bytes]. */
    private static long symbolGrowth(World world, List<WorldEdit> edits) {
        long growth = 0;
        for (WorldEdit edit : edits) {
            if (edit instanceof Add add) {
                for (ItemDefinition item : add.items) {
                    growth += SymbolBytes.of(world, item);
                }
            } else if (edit instanceof Change change) {
                Optional<Item> item = world.find(change.item);
                for (Map.Entry<String, Object> symbol : change.values.symbols().entrySet()) {
                    growth +=
                            item.isPresent()
                                    ? SymbolBytes.growth(
                                            item.get(), symbol.getKey(), symbol.getValue())
                                    : SymbolBytes.of(
                                            world, Map.of(symbol.getKey(), symbol.getValue()));
                }
            }
        }
        return growth;
    }

    /**
     * Returns the number of parts with which an edit counts that changes a level: those of the
     * largest level of the item. All other edits count with 0.
     */
    private static long partsOf(World world, WorldEdit edit) {
        if (!(edit instanceof Change change) || !change.set.contains("semantic." + Level.SYMBOL)) {
            return 0;
        }
        return world.find(change.item).stream()
                .flatMap(item -> item.levels().stream())
                .mapToLong(level -> level.items().size())
                .max()
                .orElse(0);
    }

    private static void requireFewParts(long parts) throws ActionRefused {
        if (parts > MAX_PARTS_OF_LEVELS) {
            throw new ActionRefused(
                    REFUSED,
                    "the levels that one message changes have more than "
                            + MAX_PARTS_OF_LEVELS
                            + " parts; use several messages");
        }
    }

    /** A function that is called between the check and the edits. It may refuse the edits. */
    interface Step {
        /**
         * Does the work.
         *
         * @throws ActionRefused if the edits must not be made
         */
        void run() throws ActionRefused;
    }

    private static boolean hasParts(WorldEdit edit) {
        return edit instanceof Change change
                        && (change.set.size() + change.cleared.size() > 1
                                || setsAccess(change)
                                || change.set.contains("semantic." + Level.SYMBOL)
                                || setsReferences(change))
                || edit instanceof Remove remove && remove.cascade;
    }

    private static boolean setsAccess(Change change) {
        return change.set.stream().anyMatch(key -> key.startsWith("access."));
    }

    private static boolean setsReferences(Change change) {
        return !change.values.references().isEmpty();
    }

    /** Refuses an edit after which an item refers to another one twice, like a world file. */
    private static void requireDifferent(World world, WorldEdit edit) throws ActionRefused {
        if (!(edit instanceof Change change) || !setsReferences(change)) {
            return;
        }
        Item item = find(world, change.set.contains("name") ? change.values.name() : change.item);
        Set<ItemId> targets = new HashSet<>();
        for (PropertyDescriptor property : world.prototype().references(item.kind())) {
            for (ItemId target : item.physics().references(property.name())) {
                if (!targets.add(target)) {
                    throw new ActionRefused(
                            REFUSED,
                            "item "
                                    + item.name()
                                    + ": physics."
                                    + property.name()
                                    + " refers to "
                                    + world.item(target).name()
                                    + " twice; expected different items");
                }
            }
        }
    }

    /**
     * Refuses an edit after which an item could be stored, but not read again. Such an item would
     * make the whole store unreadable.
     */
    private static void requireReadable(World world, WorldEdit edit) throws ActionRefused {
        if (!(edit instanceof Change change) || !setsAccess(change)) {
            return;
        }
        String name = change.set.contains("name") ? change.values.name() : change.item;
        Item item = find(world, name);
        ItemDefinition.Builder body = ItemDefinition.named("item");
        item.access().actions().forEach(body::action);
        item.access().capabilities().forEach(body::capability);
        item.sensors().forEach(body::sensor);
        item.voice().ifPresent(body::voice);
        String text;
        try {
            text = new ItemWriter(world.prototype()).write(body.build());
        } catch (IllegalArgumentException noFile) {
            return; // an action of a program, which no file contains
        }
        try {
            WorldFile.parseItem("item " + name, text, world.prototype());
        } catch (WorldFileException unreadable) {
            throw new ActionRefused(
                    REFUSED,
                    "the changed item could not be read again: " + unreadable.getMessage());
        }
    }

    private static void requireNotKept(Item item, Collection<ItemId> kept) throws ActionRefused {
        if (kept.contains(item.id())) {
            throw new ActionRefused(
                    "cannot-remove",
                    item.name() + " is the body of an agent, and leaves the world with it");
        }
    }

    private static void tryOut(
            World world, long frame, List<WorldEdit> edits, Collection<ItemId> kept)
            throws ActionRefused {
        try (OffHeapArena arena = new OffHeapArena();
                WorldImage image = new WorldImage(world)) {
            image.copyFrom(world, 0);
            World copy = new World(world.name(), world.prototype(), arena);
            copy.restore(image);
            long parts = 0;
            for (int i = 0; i < edits.size(); i++) {
                try {
                    parts += partsOf(copy, edits.get(i));
                    requireFewParts(parts);
                    make(copy, frame, edits.get(i));
                    requireReadable(copy, edits.get(i));
                    requireDifferent(copy, edits.get(i));
                } catch (ActionRefused refused) {
                    throw edits.size() == 1
                            ? refused
                            : new ActionRefused(
                                    refused.code(),
                                    "edit "
                                            + (i + 1)
                                            + " of "
                                            + edits.size()
                                            + ": "
                                            + refused.getMessage());
                }
            }
            for (ItemId id : kept) {
                // The item may be missing, because an agent may have removed its own body.
                Optional<Item> item = world.find(id);
                if (item.isPresent() && copy.find(id).isEmpty()) {
                    requireNotKept(item.get(), kept);
                }
            }
        }
    }

    private static void make(World world, long frame, WorldEdit edit) throws ActionRefused {
        try {
            switch (edit) {
                case Add add -> {
                    List<ItemDefinition> items =
                            add.items.stream().filter(item -> !isKnownRow(world, item)).toList();
                    requireRoom(world.itemCount(), items.size());
                    world.addAll(items).forEach(item -> world.arrests().suspect(item.id()));
                }
                case Remove remove -> {
                    ItemId id = find(world, remove.item).id();
                    if (remove.cascade) {
                        world.removeCascade(id);
                    } else {
                        world.remove(id);
                    }
                }
                case Change change -> change(world, frame, change);
            }
        } catch (IllegalArgumentException | IllegalStateException refused) {
            throw new ActionRefused(REFUSED, String.valueOf(refused.getMessage()));
        }
    }

    private static boolean isKnownRow(World world, ItemDefinition item) {
        return item.kind().equals(WorldPrototype.SUBSTANCE_PAIR)
                && world.find(item.name())
                        .filter(known -> known.kind().equals(item.kind()))
                        .isPresent();
    }

    /**
     * Refuses an edit after which the world would have too many items. Such a world could be saved,
     * but not read again.
     */
    static void requireRoom(int count, int more) throws ActionRefused {
        if (count + more > Expansion.MAX_ITEMS) {
            throw new ActionRefused(
                    REFUSED,
                    "the world has "
                            + count
                            + " items; with "
                            + more
                            + " more it would exceed the limit of "
                            + Expansion.MAX_ITEMS);
        }
    }

    private static Item find(World world, String name) throws ActionRefused {
        Optional<Item> item = world.find(name);
        if (item.isEmpty()) {
            throw new ActionRefused("no-such-item", "the world has no item \"" + name + "\"");
        }
        return item.get();
    }

    private static void change(World world, long frame, Change change) throws ActionRefused {
        Item item = find(world, change.item);
        for (String key : change.cleared) {
            clear(world, item, key);
        }
        for (String key : change.set) {
            set(world, frame, item, change.values, key);
        }
    }

    private static void clear(World world, Item item, String key) {
        String name = key.substring(key.indexOf('.') + 1);
        switch (key.substring(0, Math.max(0, key.indexOf('.')))) {
            case "semantic" -> item.semantic().remove(name);
            case "access" -> item.access().remove(name);
            case "physical" -> item.physical().setMaterial(Optional.empty());
            default -> {
                if (key.equals("parent")) {
                    LevelChange.requireOwnParent(item);
                    world.detach(item.id());
                } else {
                    requireNoLevels(item);
                    item.physics().clear();
                }
            }
        }
    }

    private static void requireNoLevels(Item item) {
        if (!item.levels().isEmpty()) {
            throw new IllegalArgumentException(
                    item + " has levels, which describe its physics; set its mass to 0 instead");
        }
    }

    private static void set(World world, long frame, Item item, ItemDefinition values, String key)
            throws ActionRefused {
        String name = key.substring(key.indexOf('.') + 1);
        switch (key.substring(0, Math.max(0, key.indexOf('.')))) {
            case "physical" -> setPhysical(world, item, values, name);
            case "physics" -> setPhysics(world, item, values, name);
            case "semantic" -> setSymbol(world, frame, item, name, values.symbols().get(name));
            case "access" -> item.access().set(action(values, name));
            default -> {
                if (key.equals("name")) {
                    world.rename(item.id(), values.name());
                } else {
                    LevelChange.requireOwnParent(item);
                    world.attach(item.id(), find(world, values.parent().orElseThrow()).id());
                }
            }
        }
    }

    private static void setSymbol(World world, long frame, Item item, String symbol, Object value) {
        if (item.isLevel(symbol)) {
            LevelChange.prepare(world, item, value).make(frame);
        } else {
            item.semantic().set(symbol, value);
        }
    }

    private static Action action(ItemDefinition values, String name) {
        return values.actions().stream()
                .filter(action -> action.name().equals(name))
                .findFirst()
                .orElseThrow();
    }

    private static void setPhysical(World world, Item item, ItemDefinition values, String key) {
        switch (key) {
            case "shape" -> item.physical().setShape(values.shape());
            case "material" -> item.physical().setMaterial(values.material());
            case "colour" ->
                    item.physical().setColour(values.look().colour().orElseGet(values::colour));
            case ConnectionLook.WIDTH -> item.physical().setWidth(values.look().width());
            case "location" -> {
                double[] at = values.location();
                item.physical().setLocation(at[0], at[1], at[2]);
                world.arrests().suspect(item.id());
            }
            default -> {
                double[] turn = values.orientation();
                item.physical().setOrientation(turn[0], turn[1], turn[2], turn[3]);
            }
        }
    }

    private static void setPhysics(World world, Item item, ItemDefinition values, String property)
            throws ActionRefused {
        @Nullable List<String> targets = values.references().get(property);
        if (targets != null) {
            List<ItemId> ids = new ArrayList<>();
            for (String target : targets) {
                ids.add(find(world, target).id());
            }
            item.physics().setReferences(property, ids.toArray(ItemId[]::new));
            return;
        }
        double[] numbers = values.physics(property).orElseThrow();
        Optional<PropertyDescriptor> column = world.prototype().find(item.kind(), property);
        Optional<String> why = column.flatMap(known -> Possible.refusal(known, numbers));
        if (why.isPresent()) {
            throw new ActionRefused(
                    "out-of-range",
                    "item "
                            + item.name()
                            + ": physics."
                            + property
                            + " is "
                            + (numbers.length == 1 ? numbers[0] : Arrays.toString(numbers))
                            + "; "
                            + why.get());
        }
        item.physics().set(property, numbers);
        world.arrests().suspect(item.id());
    }

    /** Returns the kinds of the items that edits add, by name. */
    static Map<String, String> kinds(List<WorldEdit> edits) {
        Map<String, String> kinds = new HashMap<>();
        for (WorldEdit edit : edits) {
            if (edit instanceof Add add) {
                add.items.forEach(item -> kinds.put(item.name(), item.kind()));
            } else if (edit instanceof Change change && change.set.contains("name")) {
                kinds.put(change.values.name(), change.values.kind());
            }
        }
        return kinds;
    }
}
