// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.mesh.Assets;
import reve.core.world.Action;
import reve.core.world.ItemDefinition;
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
 * Reader of items with their four aspects. After the items, it reads the references between them.
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
    private final ItemMentions names;
    private final BodyCheck bodies;

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

    /** Reads one aspect of an item. */
    private interface AspectReading {
        void read(Node aspect, ItemDefinition.Builder item) throws WorldFileException;
    }

    /**
     * The key of a shared aspect. It contains the node of the prefab, and the data of the item that
     * determine how the node is read.
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
        this.bodies = new BodyCheck(doubts, problems);
        this.beginning = doubts == Doubts.IGNORED ? ItemDefinition::kept : ItemDefinition::named;
    }

    /** Returns all valid items under the key {@code items}. */
    List<ItemDefinition> readAll(List<Node> nodes, Expansion expansion) throws WorldFileException {
        List<ItemDefinition> items = new ArrayList<>();
        var sink =
                new Expansion.Sink() {
                    @Override
                    public void accept(Node item) throws WorldFileException {
                        Optional<ItemDefinition> read = read(item);
                        read.ifPresent(items::add);
                        read.ifPresent(_ -> places.add(Places.Place.of(item)));
                    }

                    @Override
                    public void accept(Template item, Repetition repetition)
                            throws WorldFileException {
                        readRepeated(item, repetition, items);
                    }
                };
        expansion.requireRoom(nodes);
        for (Node node : nodes) {
            expansion.expand(node, sink);
        }
        names.resolve();
        return items;
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
        Node template = completion.complete(description);
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
        }
        return item.map(ItemDefinition.Builder::build);
    }

    /** Reads the new values of an item. Does not check references to other items. */
    ItemDefinition readChange(Node node, String kind) throws WorldFileException {
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
        Node node = completion.complete(description);
        Optional<String> kind = kind(node);
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

    /**
     * Reads the first repetition of an item completely. If possible, reads only the differing
     * values of the other repetitions.
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
                Optional<ItemDefinition> item = read(node);
                item.ifPresent(items::add);
                item.ifPresent(_ -> places.add(Places.Place.of(node)));
                List<Template.Made> parts = template.makeParts(values, n);
                repeated =
                        item.map(first -> new RepeatedItem(node, first))
                                .filter(first -> first.differsInSingleValues(parts));
            }
        }
    }

    /** Gives the last repetition the file position of the repetition before it. */
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

    /** Reads an item. Its content is checked even if its name is wrong. */
    private Optional<ItemDefinition> read(Node node) throws WorldFileException {
        Optional<String> kind = kind(node);
        Optional<ItemDefinition.Builder> named =
                node.get("name").flatMap(name -> named(name, kind.orElse(""), hasPhysics(node)));
        ItemDefinition.Builder item = named.orElseGet(() -> ItemDefinition.named("unnamed"));
        if (kind.isPresent()) {
            item.kind(kind.get());
            node.get("parent").ifPresent(parent -> readParent(parent, kind.get(), item));
            readAspects(node, kind.get(), hasPhysics(node), item);
            requireReferences(node, kind.get());
        }
        Optional<ItemDefinition> read = named.map(ItemDefinition.Builder::build);
        read.ifPresent(
                complete -> {
                    refuseMassOfChild(node, complete);
                    bodies.check(node, complete);
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
     * Returns the kind of an item. If items cannot have this kind, records a problem and returns
     * empty.
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
        } else if (place.isPresent()) {
            problems.addAtKey(
                    place.get(), "only items of kind body have `physical`, this is a " + kind);
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
        if (properties.isPresent() && physics.density(properties.get(), kind).isEmpty()) {
            read(
                    node,
                    properties.get(),
                    kind,
                    hasPhysics,
                    item,
                    (aspect, into) -> readPhysics(aspect, kind, into),
                    item::physicsOf);
        } else if (properties.isPresent()) {
            // This follows the shape, because a density needs the shape to compute the mass.
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
        item.get("access")
                .flatMap(access -> access.get(Voice.SAY))
                .ifPresent(
                        action ->
                                problems.addAtKey(
                                        action,
                                        "say: an item with a `voice` has an action of this name; "
                                                + "rename this action, or leave out the voice"));
        sensors.readVoice(voice).ifPresent(into::voice);
    }

    /**
     * Reads an aspect. If items take the aspect unchanged from a prefab, it is read for the first
     * of these items only.
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
     * Reads the actions of an item. If items take the actions unchanged from a prefab, they are
     * read once for all of these items.
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
                // the schema check has reported the problem
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
        symbolValue(symbol)
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
     * Reads the value of a symbol. If the symbol has a declared unit, the number may be given in
     * another unit, as for a property.
     */
    private Optional<Object> symbolValue(Node symbol) {
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

    private void requireReferences(
            Function<String, Optional<Node>> values, Node aspect, String kind) {
        Set<String> targets = new HashSet<>();
        for (PropertyDescriptor property : prototype.references(kind)) {
            Optional<Node> given = values.apply(property.name());
            if (given.isEmpty()) {
                problems.addAtKey(
                        aspect,
                        "a " + kind + " needs `" + property.name() + "`: " + property.doc());
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
