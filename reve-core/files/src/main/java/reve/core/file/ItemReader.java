// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.mesh.Assets;
import reve.core.world.Action;
import reve.core.world.ConnectionLook;
import reve.core.world.ItemDefinition;
import reve.core.world.Level;
import reve.core.world.PropertyDescriptor;
import reve.core.world.SemanticAspect;
import reve.core.world.SymbolDescriptor;
import reve.core.world.SymbolType;
import reve.core.world.Voice;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.BiConsumer;
import java.util.function.BiFunction;
import java.util.function.Consumer;
import java.util.function.Function;

/**
 * Reader of items with their four aspects. It reads the references between items after all items
 * were read.
 */
final class ItemReader {
    private final WorldPrototype prototype;
    private final Completion completion;

    /**
     * Maximum nesting depth of items that actions create. The level increases when a created item
     * has an action that creates items.
     */
    private static final int MAX_CREATED_DEPTH = 8;

    /**
     * Maximum number of definitions of items that actions create. A definition counts each time it
     * is read.
     */
    private static final int MAX_CREATED = 10_000;

    /**
     * Maximum number of values that are read for single items. Values that are read once in a
     * prefab do not count.
     */
    static final int MAX_READ = 2_000_000;

    /**
     * Number of values per aspect that do not count towards {@link #MAX_READ}. All values of
     * actions count.
     */
    private static final int FREE_VALUES = 16;

    private final Problems problems;
    private final PhysicsReader physics;
    private final PhysicalReader physical;
    private final DensityReader densities;
    private final ActionReader actions;
    private final SensorReader sensors;
    private final LevelReader levels;

    /** The names of the items, or of the parts of the level that is being read. */
    private ItemMentions names;

    private final BodyCheck bodies;
    private final ClassValues classes;

    /** Creates the builder of an item from its name. Throws an exception if the name is invalid. */
    private final Function<String, ItemDefinition.Builder> beginning;

    /**
     * Aspects that items take unchanged from prefabs. Each aspect is read once, as a definition.
     */
    private final Map<SharedAspect, ItemDefinition> shared = new HashMap<>();

    private final Allowance created = new Allowance(MAX_CREATED);
    private final Allowance work = new Allowance(MAX_READ);
    private final List<Places.Place> places = new ArrayList<>();
    private int createdDepth;
    private Optional<Expansion> expansion = Optional.empty();
    private boolean isInLevel;

    /** Whether the reader reads a change of an item, in which a substance determines no mass. */
    private boolean isChange;

    /** Reads one aspect of an item. */
    private interface AspectReading {
        void read(Node aspect, ItemDefinition.Builder item) throws WorldFileException;
    }

    /**
     * The key of a shared aspect. It contains the node of the prefab. It also contains the data of
     * the item on which the reading of this node depends.
     */
    private record SharedAspect(Node aspect, String kind, boolean hasPhysics) {}

    /** Completes an item from its prefab. */
    interface Completion {
        Node complete(Node item) throws WorldFileException;
    }

    /**
     * @param pathOf returns the path of a file that a value names, relative to the folder of the
     *     assets
     */
    ItemReader(
            WorldPrototype prototype,
            PhysicsReader physics,
            Assets assets,
            BiFunction<Node, String, String> pathOf,
            Completion completion,
            Doubts doubts,
            Problems problems) {
        this.prototype = prototype;
        this.completion = completion;
        this.problems = problems;
        this.names = new ItemMentions(problems);
        this.physics = physics;
        this.physical = new PhysicalReader(prototype, physics, assets, pathOf, problems);
        this.densities = new DensityReader(prototype, physics, problems);
        this.actions = new ActionReader(physics, this::readCreated, problems);
        this.sensors = new SensorReader(problems);
        this.levels = new LevelReader(prototype, this::readApart, doubts, problems);
        this.bodies = new BodyCheck(doubts, problems);
        this.classes = new ClassValues(prototype, problems);
        this.beginning = doubts == Doubts.IGNORED ? ItemDefinition::kept : ItemDefinition::named;
    }

    /** Takes the expressions of all actions from an allowance that other readers share. */
    void shareExpressions(Allowance left) {
        actions.share(left);
    }

    /** Returns all valid items under the key {@code items}. */
    List<ItemDefinition> readAll(List<Node> nodes, Expansion expansion) throws WorldFileException {
        List<ItemDefinition> items = new ArrayList<>();
        this.expansion = Optional.of(expansion);
        var sink =
                sink(
                        expansion,
                        (item, placement) -> readInto(items, item, placement),
                        (item, repetition) -> readRepeated(item, repetition, items));
        expansion.requireRoom(nodes);
        for (Node node : nodes) {
            expansion.expand(node, sink);
        }
        names.resolve();
        return items;
    }

    /** A receiver of the repetitions of an item. */
    private interface Repeating {
        void accept(Template item, Repetition repetition) throws WorldFileException;
    }

    /** Returns a receiver of expanded items that passes on the parts of groups one by one. */
    private Expansion.Sink sink(Expansion from, GroupReader.Sink single, Repeating repeated) {
        var groups = new GroupReader(prototype, from, physical, problems, single);
        return new Expansion.Sink() {
            @Override
            public void accept(Node item) throws WorldFileException {
                if (GroupReader.isGroup(item) && !LevelReader.hasLevels(item)) {
                    groups.read(item);
                } else {
                    single.accept(item, Placement.NONE);
                }
            }

            @Override
            public void accept(Template item, Repetition repetition) throws WorldFileException {
                repeated.accept(item, repetition);
            }
        };
    }

    private void readInto(List<ItemDefinition> items, Node item, Placement placement)
            throws WorldFileException {
        List<ItemDefinition> read =
                LevelReader.hasLevels(item)
                        ? readWithLevels(item, placement)
                        : read(item, placement, hasPhysics(item)).stream().toList();
        items.addAll(read);
        read.forEach(_ -> places.add(Places.Place.of(item)));
    }

    /** Reads an item with levels, and the parts of the level that it begins with. */
    private List<ItemDefinition> readWithLevels(Node item, Placement placement)
            throws WorldFileException {
        if (isInLevel) {
            problems.addAtKey(
                    item.get(LevelReader.LEVELS).orElseThrow(),
                    "levels: a part of a level cannot have levels itself");
            return List.of();
        }
        levels.refuseOtherKeys(item);
        Optional<Node> name = item.get("name").filter(node -> node.text().isPresent());
        List<Level> all = levels.read(item, name.flatMap(Node::text).orElse("unnamed"));
        boolean isComplete = LevelReader.isComplete(item);
        boolean isSingle = all.stream().noneMatch(Level::isGroup);
        Optional<ItemDefinition> read =
                read(
                        item,
                        isComplete ? placement : Placement.NONE,
                        hasPhysics(item) || !isComplete);
        Optional<Level> active = levels.active(item, all);
        if (read.isEmpty() || active.isEmpty() || name.isEmpty()) {
            return List.of();
        }
        ItemDefinition whole = withLevels(item, read.get(), all, active.get());
        ItemDefinition body =
                all.stream()
                        .filter(level -> !level.isGroup())
                        .findFirst()
                        .map(level -> LevelReader.begin(whole, level).getFirst())
                        .orElse(whole);
        bodies.check(item, body);
        if (isComplete) {
            return List.of(whole);
        }
        if (!isSingle) {
            names.addChanging(whole.name());
        }
        for (Level level : all) {
            for (ItemDefinition part :
                    level.isGroup() ? level.items() : List.<ItemDefinition>of()) {
                names.addPart(name.get(), Level.prefix(whole.name()) + part.name(), part.kind());
            }
        }
        Placement place = placement.of(Placement.of(whole));
        ItemDefinition atOrigin =
                whole.copy(whole.name()).at(0, 0, 0).orientation(0, 0, 0, 1).build();
        return LevelReader.begin(atOrigin, active.get()).stream().map(place::placed).toList();
    }

    private ItemDefinition withLevels(
            Node item, ItemDefinition read, List<Level> all, Level active) {
        ItemDefinition.Builder whole = read.copy(read.name()).levels(all);
        try {
            whole.symbol(
                    Level.SYMBOL,
                    SemanticAspect.requireSettable(
                            prototype, read.name(), Level.SYMBOL, active.name()));
        } catch (IllegalArgumentException refused) {
            problems.addAtKey(item.get(LevelReader.LEVELS).orElseThrow(), refused.getMessage());
        }
        return whole.build();
    }

    /** Reads the content of a level, whose parts refer to each other only. */
    private List<ItemDefinition> readApart(Node content) throws WorldFileException {
        ItemMentions others = names;
        boolean wasInLevel = isInLevel;
        names = new ItemMentions(problems);
        isInLevel = true;
        try {
            Expansion from = expansion.orElse(null);
            if (from == null) {
                from = Expansion.withoutPrefabs(content, problems);
            }
            List<ItemDefinition> items = new ArrayList<>();
            var sink =
                    sink(
                            from,
                            (item, placement) -> {
                                if (LevelReader.hasLevels(item)) {
                                    readWithLevels(item, placement);
                                } else {
                                    read(item, placement, hasPhysics(item)).ifPresent(items::add);
                                }
                            },
                            (item, _) ->
                                    problems.add(
                                            content,
                                            "`repeat` does not belong to a level; write it into one"
                                                    + " of its parts"));
            Node complete = from.complete(content);
            levels.check(complete);
            if (!GroupReader.isGroup(complete)) {
                from.requireValues(complete);
            }
            from.expand(complete, sink);
            names.resolve();
            return items;
        } finally {
            names = others;
            isInLevel = wasInLevel;
        }
    }

    /** Returns the position in the file of each item that {@link #readAll} has returned. */
    List<Places.Place> places() {
        return places;
    }

    /** Returns the names of the read items, and the references between them. */
    ItemMentions names() {
        return names;
    }

    /**
     * Returns the template of the bodies that are created for agents. The caller renames each body.
     */
    ItemDefinition readTemplate(Node description) throws WorldFileException {
        Node template = classes.complete(completion.complete(description), WorldPrototype.BODY);
        refuseGroup(template, "body: is like a group of items, expected one item");
        ItemDefinition.Builder item = ItemDefinition.named("agent");
        kind(template)
                .filter(kind -> !kind.equals(WorldPrototype.BODY))
                .ifPresent(
                        kind ->
                                problems.add(
                                        template, "body: is like a " + kind + ", expected a body"));
        readAspects(template, WorldPrototype.BODY, hasPhysics(template), item);
        bodies.check(template, item.build());
        return item.build();
    }

    /**
     * Reads an item from a store file, without the other items of its world. Does not check
     * references to other items.
     */
    Optional<ItemDefinition> readAlone(Node node) throws WorldFileException {
        Optional<String> kind = kind(node);
        Optional<ItemDefinition.Builder> item =
                node.get("name").flatMap(name -> named(name, kind.orElse(""), hasPhysics(node)));
        if (kind.isPresent() && item.isPresent()) {
            item.get().kind(kind.get());
            node.get("parent").ifPresent(parent -> readParent(parent, kind.get(), item.get()));
            readAspects(node, kind.get(), true, item.get());
            if (LevelReader.hasLevels(node)) {
                item.get().levels(levels.read(node, item.get().name()));
            }
        }
        return item.map(ItemDefinition.Builder::build);
    }

    /** Reads the new values of an item. Does not check references to other items. */
    ItemDefinition readChange(Node node, String kind) throws WorldFileException {
        isChange = true;
        try {
            ItemDefinition.Builder item =
                    beginning.apply(node.get("name").flatMap(Node::text).orElse(""));
            node.get("parent").flatMap(Node::text).ifPresent(item::parent);
            readAspects(node, kind, true, item.kind(kind));
            return item.build();
        } catch (IllegalArgumentException refused) {
            problems.add(node, refused.getMessage());
            return ItemDefinition.kept("unnamed").build();
        }
    }

    /** Reads a part of an item only to record its problems. */
    void readPart(Node node, String kind) throws WorldFileException {
        if (kind(node).isPresent()) {
            readAspects(node, kind, true, ItemDefinition.named("prefab"));
        }
    }

    /**
     * Reads the definition of an item that an action creates. One action may create several items
     * from it.
     */
    private Optional<ItemDefinition> readCreated(Node description) throws WorldFileException {
        if (createdDepth == MAX_CREATED_DEPTH || !created.take(1)) {
            problems.add(
                    description,
                    "create: the actions of a created item may create items "
                            + "in turn, at most "
                            + MAX_CREATED_DEPTH
                            + " deep and "
                            + MAX_CREATED
                            + " times in one world; a prefab cannot create itself");
            return Optional.empty();
        }
        createdDepth++;
        try {
            return readCreatedHere(description);
        } finally {
            createdDepth--;
        }
    }

    private Optional<ItemDefinition> readCreatedHere(Node description) throws WorldFileException {
        Node described = completion.complete(description);
        refuseGroup(described, "create: is a group of items, expected one item");
        Optional<String> kind = kind(described);
        Node node = classes.complete(described, kind.orElse(""));
        Optional<String> name = node.get("name").flatMap(Node::text);
        if (kind.isEmpty() || name.isEmpty()) {
            return Optional.empty();
        }
        try {
            ItemDefinition.Builder item = beginning.apply(name.get()).kind(kind.get());
            node.get("parent")
                    .filter(parent -> parent.text().isPresent())
                    .ifPresent(
                            parent -> {
                                item.parent(parent.text().orElseThrow());
                                names.mention(parent, WorldPrototype.BODY, false);
                            });
            readAspects(node, kind.get(), hasPhysics(node), item);
            requireReferences(node, kind.get());
            node.get("repeat")
                    .ifPresent(
                            repeat ->
                                    problems.addAtKey(
                                            repeat,
                                            "`repeat` does not go with `create`, which makes one"
                                                    + " item each time; write the effect as often as"
                                                    + " items are wanted"));
            bodies.check(node, item.build());
            return Optional.of(item.build());
        } catch (IllegalArgumentException refused) {
            return refuse(node.get("name").orElse(node), refused.getMessage());
        }
    }

    private void refuseGroup(Node item, String message) {
        if (GroupReader.isGroup(item)) {
            problems.add(item, message);
        } else if (LevelReader.hasLevels(item)) {
            problems.add(
                    item,
                    item.label() + ": has levels, which only items of the world file can have");
        }
    }

    /**
     * Reads the first repetition of an item completely. Reads only the differing values of the
     * other repetitions if possible.
     */
    private void readRepeated(Template template, Repetition repetition, List<ItemDefinition> items)
            throws WorldFileException {
        Optional<RepeatedItem> repeated = Optional.empty();
        for (long n = 0; n < repetition.count() && !problems.full(); n++) {
            double[] values = repetition.values().at(n);
            if (repeated.isPresent()) {
                readAgain(repeated.get(), template.makeParts(values, n)).ifPresent(items::add);
                share(items.size());
            } else {
                Node node = template.make(values, n);
                Optional<ItemDefinition> item = read(node, Placement.NONE, hasPhysics(node));
                item.ifPresent(items::add);
                item.ifPresent(_ -> places.add(Places.Place.of(node)));
                List<Template.Made> parts = template.makeParts(values, n);
                repeated =
                        item.map(first -> new RepeatedItem(node, first))
                                .filter(first -> first.differsInSingleValues(parts))
                                .filter(_ -> !classes.areDeclared() || !differInClass(parts));
            }
        }
    }

    private static boolean differInClass(List<Template.Made> values) {
        return values.stream()
                .anyMatch(
                        made ->
                                made.aspect().equals("semantic")
                                        && made.value().key().equals("class"));
    }

    /**
     * Gives the last repetition the same file position as the repetition before it, so that all
     * repetitions share one object.
     */
    private void share(int count) {
        if (places.size() < count) {
            places.add(places.getLast());
        }
    }

    /** Reads a repetition that differs from the first item in the given values. */
    private Optional<ItemDefinition> readAgain(RepeatedItem first, List<Template.Made> values)
            throws WorldFileException {
        ItemDefinition definition = first.definition();
        Optional<ItemDefinition.Builder> named =
                named(first.name(values), definition.kind(), definition.hasPhysics())
                        .map(name -> definition.copy(name.name()));
        ItemDefinition.Builder item = named.orElseGet(() -> definition.copy("unnamed"));
        for (Template.Made made : values) {
            switch (made.aspect()) {
                case "physical" -> physical.readPlaceOrColour(made.value(), item);
                case "semantic" -> readSymbol(made.value(), item);
                case "physics" ->
                        physics.readProperty(
                                made.value(), definition.kind(), sink(item, item::physics));
                default -> {} // the name was read before, and the parent is read last
            }
        }
        first.parent(values).ifPresent(parent -> readParent(parent, definition.kind(), item));
        if (!definition.references().isEmpty()) {
            requireReferences(
                    property -> first.physics(values, property),
                    first.node().get("physics").orElseThrow(),
                    definition.kind());
        }
        Optional<ItemDefinition> read = named.map(ItemDefinition.Builder::build);
        read.ifPresent(complete -> bodies.check(first.node(), complete));
        return read;
    }

    /**
     * Reads an item. Its content is checked even if its name is wrong.
     *
     * @param placement the place of the item's group
     * @param hasPhysics whether other items can refer to the item's physics
     */
    private Optional<ItemDefinition> read(Node description, Placement placement, boolean hasPhysics)
            throws WorldFileException {
        Optional<String> kind = kind(description);
        Node node = classes.complete(description, kind.orElse(""));
        Optional<ItemDefinition.Builder> named =
                node.get("name").flatMap(name -> named(name, kind.orElse(""), hasPhysics));
        ItemDefinition.Builder item = named.orElseGet(() -> ItemDefinition.named("unnamed"));
        if (kind.isPresent()) {
            item.kind(kind.get());
            node.get("parent").ifPresent(parent -> readParent(parent, kind.get(), item));
            // An item whose present level has parts may have physics at another one.
            readAspects(node, kind.get(), hasPhysics || LevelReader.hasLevels(node), item);
            requireReferences(node, kind.get());
        }
        Optional<ItemDefinition> read =
                named.map(ItemDefinition.Builder::build).map(placement::placed);
        read.ifPresent(
                complete -> {
                    refuseMassOfChild(node, complete);
                    if (!LevelReader.hasLevels(node)) {
                        bodies.check(node, complete);
                    }
                });
        return read;
    }

    private Optional<ItemDefinition.Builder> named(Node node, String kind, boolean hasPhysics) {
        Optional<String> name = node.text();
        if (name.isEmpty()) {
            return Optional.empty();
        }
        if (name.get().equals(WorldPrototype.WORLD)) {
            return refuse(
                    node,
                    "name: `world` is the item that holds the constants; they belong "
                            + "under `constants`");
        }
        if (!names.add(node, kind, hasPhysics)) {
            return Optional.empty();
        }
        try {
            return Optional.of(beginning.apply(name.get()));
        } catch (IllegalArgumentException refused) {
            return refuse(node, refused.getMessage());
        }
    }

    /**
     * Returns the kind of an item. Records a problem and returns empty if items cannot have this
     * kind.
     */
    private Optional<String> kind(Node item) {
        Optional<Node> node = item.get("kind");
        String kind = node.flatMap(Node::text).orElse(WorldPrototype.BODY);
        if (kind.equals(WorldPrototype.WORLD)) {
            return refuse(
                    node.orElseThrow(),
                    "kind: there is only one world; its properties belong under `constants`");
        }
        if (!prototype.hasKind(kind)) {
            return refuse(
                    node.orElseThrow(),
                    "kind: no properties are declared for kind `"
                            + kind
                            + "`, known are "
                            + Node.list(prototype.kinds())
                            + problems.suggestion(kind, prototype.kinds()));
        }
        return Optional.of(kind);
    }

    private <T> Optional<T> refuse(Node node, String message) {
        problems.add(node, message);
        return Optional.empty();
    }

    private static boolean hasPhysics(Node item) {
        return item.get("physics").filter(aspect -> !aspect.children().isEmpty()).isPresent();
    }

    private void readParent(Node parent, String kind, ItemDefinition.Builder item) {
        if (parent.text().isEmpty()) {
            return;
        }
        if (!kind.equals(WorldPrototype.BODY)) {
            problems.addAtKey(parent, "only items of kind body have a `parent`, this is a " + kind);
            return;
        }
        item.parent(parent.text().orElseThrow());
        names.mentionParent(item.name(), parent);
    }

    private void refuseMassOfChild(Node node, ItemDefinition item) {
        boolean massive = item.physics("mass").filter(mass -> mass[0] != 0).isPresent();
        if (massive && item.parent().isPresent()) {
            problems.add(
                    node.get("physics").flatMap(aspect -> aspect.get("mass")).orElse(node),
                    "mass: an item with a `parent` moves with it and not by laws; "
                            + "expected mass 0, or none");
        }
    }

    private void readAspects(
            Node node, String kind, boolean hasPhysics, ItemDefinition.Builder item)
            throws WorldFileException {
        classes.check(node, kind);
        Optional<Node> place = node.get("physical");
        if (place.isPresent() && kind.equals(WorldPrototype.BODY)) {
            read(
                    node,
                    place.get(),
                    kind,
                    hasPhysics,
                    item,
                    (aspect, into) -> {
                        requireWork(aspect, FREE_VALUES);
                        physical.read(aspect, into);
                    },
                    item::physicalOf);
        } else if (place.isPresent() && ConnectionLook.KINDS.contains(kind)) {
            read(
                    node,
                    place.get(),
                    kind,
                    hasPhysics,
                    item,
                    (aspect, into) -> physical.readLook(aspect, kind, into),
                    item::physicalOf);
        } else if (place.isPresent()) {
            problems.addAtKey(
                    place.get(),
                    "only items of kind body, spring or surface have `physical`, this is a "
                            + kind);
        }
        if (node.get("semantic").isPresent()) {
            read(
                    node,
                    node.get("semantic").get(),
                    kind,
                    hasPhysics,
                    item,
                    this::readSymbols,
                    item::symbolsOf);
        }
        Optional<Node> properties = node.get("physics");
        if (properties.isPresent() && !physics.needsShape(properties.get(), kind)) {
            read(
                    node,
                    properties.get(),
                    kind,
                    hasPhysics,
                    item,
                    (aspect, into) -> readPhysics(aspect, kind, into),
                    item::physicsOf);
        } else if (properties.isPresent()) {
            // The physics aspect is read after the shape, because the mass is computed from a
            // density and the shape.
            readPhysics(properties.get(), kind, item);
        }
        if (node.get("capabilities").isPresent()) {
            requireWork(node.get("capabilities").get(), FREE_VALUES);
            readCapabilities(node.get("capabilities").get(), item);
        }
        if (node.get("access").isPresent()) {
            read(
                    node,
                    node.get("access").get(),
                    kind,
                    hasPhysics,
                    item,
                    (aspect, into) -> readActions(aspect, kind, hasPhysics, into),
                    item::actionsOf);
        }
        if (node.get("sensors").isPresent()) {
            requireWork(node.get("sensors").get(), FREE_VALUES);
        }
        node.get("sensors")
                .ifPresent(
                        all -> {
                            if (kind.equals(WorldPrototype.BODY)) {
                                all.children()
                                        .forEach(
                                                sensor ->
                                                        sensors.read(sensor)
                                                                .ifPresent(item::sensor));
                            } else {
                                problems.addAtKey(
                                        all,
                                        "only items of kind body have `sensors`, this is a "
                                                + kind);
                            }
                        });
        if (node.get("voice").isPresent()) {
            readVoice(node, node.get("voice").get(), kind, item);
        }
    }

    private void readVoice(Node item, Node voice, String kind, ItemDefinition.Builder into)
            throws WorldFileException {
        requireWork(voice, FREE_VALUES);
        if (!kind.equals(WorldPrototype.BODY)) {
            problems.addAtKey(voice, "only items of kind body have a `voice`, this is a " + kind);
            return;
        }
        Optional<Node> say = item.get("access").flatMap(access -> access.get(Voice.SAY));
        if (say.isPresent()) {
            problems.addAtKey(
                    say.get(),
                    "say: an item with a `voice` has an action of this name; rename this action, or"
                            + " leave out the voice");
            return;
        }
        sensors.readVoice(voice).ifPresent(into::voice);
    }

    /**
     * Reads an aspect. An aspect that items take unchanged from a prefab is read for the first of
     * these items only.
     */
    private void read(
            Node node,
            Node aspect,
            String kind,
            boolean hasPhysics,
            ItemDefinition.Builder item,
            AspectReading reading,
            Consumer<ItemDefinition> taking)
            throws WorldFileException {
        if (aspect.isWrittenIn(node)) {
            reading.read(aspect, item);
            return;
        }
        var key = new SharedAspect(aspect, kind, hasPhysics);
        ItemDefinition read = shared.get(key);
        if (read == null) {
            ItemDefinition.Builder first = ItemDefinition.kept(item.name()).kind(kind);
            reading.read(aspect, first);
            read = first.build();
            shared.put(key, read);
        }
        taking.accept(read);
    }

    /**
     * Counts the values of a part that is read for a single item. Throws an exception if the values
     * of all parts exceed {@link #MAX_READ}.
     */
    private void requireWork(Node part, int free) throws WorldFileException {
        if (!work.take(Math.max(0, part.valueCount() - free))) {
            throw problems.of(part.file())
                    .fatal(
                            part.keyLine(),
                            part.keyColumn(),
                            part.label()
                                    + ": actions, symbols and other values that are read for each"
                                    + " item again are more than "
                                    + MAX_READ
                                    + " in all items, which is the limit: move values that do not"
                                    + " change into a prefab that the items are `like`, in an aspect"
                                    + " or an action that the items do not declare");
        }
    }

    /**
     * Reads the actions of an item. Actions that items take unchanged from a prefab are read once
     * for all of these items.
     */
    private void readActions(
            Node access, String kind, boolean hasPhysics, ItemDefinition.Builder item)
            throws WorldFileException {
        var owner = new ActionReader.Owner(item.name(), kind, hasPhysics);
        for (Node each : access.children()) {
            if (problems.full()) {
                return;
            }
            read(
                    access,
                    each,
                    kind,
                    hasPhysics,
                    item,
                    (action, into) -> {
                        requireWork(action, 0);
                        Optional<Action> read = actions.read(action, owner);
                        read.ifPresent(into::action);
                    },
                    read -> read.actions().forEach(item::action));
        }
    }

    private static void readCapabilities(Node all, ItemDefinition.Builder item) {
        for (Node capability : all.children()) {
            try {
                capability.text().ifPresent(item::capability);
            } catch (IllegalArgumentException noName) {
                // No problem is recorded here, because the schema check has already reported it.
            }
        }
    }

    private void readSymbols(Node aspect, ItemDefinition.Builder item) throws WorldFileException {
        requireWork(aspect, FREE_VALUES);
        for (Node symbol : aspect.children()) {
            if (problems.full()) {
                return;
            }
            readSymbol(symbol, item);
        }
    }

    private void readSymbol(Node symbol, ItemDefinition.Builder item) {
        symbolValue(symbol, prototype, problems)
                .ifPresent(
                        value -> {
                            try {
                                item.symbol(
                                        symbol.key(),
                                        SemanticAspect.requireSettable(
                                                prototype, item.name(), symbol.key(), value));
                            } catch (IllegalArgumentException refused) {
                                problems.addAtKey(symbol, refused.getMessage());
                            }
                        });
    }

    /**
     * Reads the value of a symbol. The number of a symbol with a declared unit may be given in
     * another unit, as for a property.
     */
    static Optional<Object> symbolValue(Node symbol, WorldPrototype prototype, Problems problems) {
        Optional<SymbolDescriptor> number =
                prototype
                        .symbol(symbol.key())
                        .filter(declared -> declared.type() == SymbolType.NUMBER);
        return number.isEmpty()
                ? OperandReader.constant(symbol)
                : new Quantities(problems).number(symbol, number.get().unit()).map(value -> value);
    }

    private void readPhysics(Node aspect, String kind, ItemDefinition.Builder item)
            throws WorldFileException {
        requireWork(aspect, FREE_VALUES);
        Map<String, double[]> numbers = new LinkedHashMap<>();
        physics.read(aspect, kind, sink(item, numbers::put));
        item.physics(numbers);
        physics.density(aspect, kind).ifPresent(value -> densities.read(value, aspect, item));
        Optional<Node> name = physics.massySubstance(aspect, kind).filter(_ -> !isChange);
        if (name.isPresent() && item.build().parent().isEmpty()) {
            physics.substance(name.get())
                    .ifPresent(substance -> densities.read(name.get(), substance, aspect, item));
        }
    }

    private PhysicsReader.Sink sink(
            ItemDefinition.Builder item, BiConsumer<String, double[]> numbers) {
        return new PhysicsReader.Sink() {
            @Override
            public void numbers(String property, double[] values) {
                numbers.accept(property, values);
            }

            @Override
            public void references(PropertyDescriptor property, List<Node> targets) {
                item.reference(
                        property.name(),
                        targets.stream()
                                .map(target -> target.text().orElseThrow())
                                .toArray(String[]::new));
                targets.forEach(
                        target -> names.mention(target, property.refersTo().orElseThrow(), true));
            }
        };
    }

    /**
     * Checks that a physics aspect has every reference of the kind, for example {@code end1} and
     * {@code end2}, and that they refer to different items.
     */
    private void requireReferences(Node item, String kind) {
        if (!hasPhysics(item)) {
            return;
        }
        Node aspect = item.get("physics").orElseThrow();
        requireReferences(aspect::get, aspect, kind);
    }

    /** Returns what a reference property of an item holds. */
    private static String expected(PropertyDescriptor property) {
        if (!property.doc().isEmpty()) {
            return property.doc();
        }
        String kind = property.refersTo().orElseThrow();
        return property.components() == 1
                ? "the name of an item of kind " + kind
                : property.components() + " names of items of kind " + kind;
    }

    private void requireReferences(
            Function<String, Optional<Node>> values, Node aspect, String kind) {
        Set<String> targets = new HashSet<>();
        for (PropertyDescriptor property : prototype.references(kind)) {
            Optional<Node> given = values.apply(property.name());
            if (given.isEmpty()) {
                problems.addAtKey(
                        aspect,
                        "a " + kind + " needs `" + property.name() + "`: " + expected(property));
                continue;
            }
            for (Node mention :
                    property.components() == 1 ? List.of(given.get()) : given.get().children()) {
                mention.text()
                        .filter(target -> !targets.add(target))
                        .ifPresent(
                                twice ->
                                        problems.add(
                                                mention,
                                                mention.label()
                                                        + ": `"
                                                        + Node.shorten(twice)
                                                        + "` is referred to twice; expected"
                                                        + " different items"));
            }
        }
    }
}
