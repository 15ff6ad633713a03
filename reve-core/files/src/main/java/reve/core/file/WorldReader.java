// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.frame.Timing;
import reve.core.mesh.Assets;
import reve.core.rule.Rule;
import reve.core.rule.Rules;
import reve.core.text.VisibleName;
import reve.core.unit.Unit;
import reve.core.world.ItemDefinition;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.Collection;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.TreeSet;
import java.util.regex.Matcher;
import java.util.regex.Pattern;
import java.util.stream.Collectors;
import java.util.stream.Stream;

/**
 * Reader of a whole world file after the schema check. It checks the conditions that the schema
 * cannot express.
 */
final class WorldReader {
    private static final Pattern FIRST_LAW =
            Pattern.compile("(?m)^law[ \\t]+([A-Za-z_][A-Za-z0-9_]{0,46})");

    /**
     * Maximum number of numbers in the declared properties of all items; 400 MB in 64-bit numbers.
     */
    private static final long MAX_NUMBERS = 50_000_000;

    private static final Unit METRE = Unit.parse("m");

    private final Assets assets;
    private final Problems problems;
    private final Quantities quantities;
    private final Expansion.Limits limits;

    WorldReader(Assets assets, Problems problems) {
        this(assets, Expansion.Limits.ofWorld(), problems);
    }

    /**
     * @param limits limits on what the items of the world create
     */
    WorldReader(Assets assets, Expansion.Limits limits, Problems problems) {
        this.assets = assets;
        this.limits = limits;
        this.problems = problems;
        this.quantities = new Quantities(problems);
    }

    WorldDescription read(WorldSource source) throws WorldFileException {
        Node root = source.world();
        var prototypeReader = new PrototypeReader(problems);
        var ruleReader = new RuleReader(problems);
        WorldPrototype withSymbols =
                ruleReader.readSymbols(
                        source.named("symbols"),
                        prototypeReader.read(
                                root,
                                source.all("properties"),
                                Stream.of(
                                                source.each("items"),
                                                source.each("prefabs"),
                                                source.each("classes"),
                                                source.named("rules"),
                                                root.get("agents").stream().toList())
                                        .flatMap(List::stream)
                                        .toList(),
                                source.named("substances"),
                                source.named("classes")));
        var expansion = new Expansion(source, limits, problems);
        long age = wholeNumber(root.get("frame"), "age", 0);
        Doubts doubts = Doubts.of(age > 0);
        List<Node> ownSubstances = source.named("substances");
        Substances substances = new SubstanceReader(problems).read(ownSubstances);
        var classReader =
                new ClassReader(
                        withSymbols,
                        new PhysicsReader(
                                withSymbols,
                                prototypeReader.misdeclared(),
                                substances,
                                doubts,
                                problems),
                        problems);
        WorldPrototype prototype = classReader.read(source.named("classes"));
        var physics =
                new PhysicsReader(
                        prototype, prototypeReader.misdeclared(), substances, doubts, problems);
        var itemReader =
                new ItemReader(
                        prototype,
                        physics,
                        assets,
                        source.files()::pathOf,
                        expansion::complete,
                        doubts,
                        problems);
        List<ItemDefinition> items = itemReader.readAll(source.all("items"), expansion);
        requireRoom(source.all("properties"), items);
        var forceReader = new ForceReader(itemReader.names(), items, physics, doubts, problems);
        List<LastingForce> forces = root.get("forces").map(forceReader::readAll).orElse(List.of());
        List<LawReference> laws = laws(source.all("laws"), physics);
        Map<String, List<Double>> constants = physics.constants(source.each("constants"));
        var cameraReader = new CameraReader(itemReader.names(), problems);
        Optional<CameraDescription> camera = root.get("camera").flatMap(cameraReader::read);
        List<NamedCamera> cameras =
                root.get("cameras").map(cameraReader::readAll).orElse(List.of());
        AgentPolicy agents =
                root.get("agents").isEmpty()
                        ? AgentPolicy.none()
                        : agents(
                                root.get("agents").get(),
                                itemReader,
                                new BodyCheck(doubts, problems));
        root.get("agents").ifPresent(node -> new RayLimit(problems).check(node, agents, items));
        var prefabs =
                new PrefabCheck(
                        prototype,
                        new ItemReader(
                                prototype,
                                physics,
                                assets,
                                source.files()::pathOf,
                                expansion::complete,
                                doubts,
                                problems));
        for (Node prefab : expansion.unusedPrefabs()) {
            problems.throwIfFull();
            prefabs.check(prefab, expansion::complete);
        }
        List<Rule> rules = ruleReader.readRules(source.named("rules"), prototype);
        if (prototype.hasSubstances()) {
            Set<Integer> used = new TreeSet<>(physics.usedSubstances());
            used.addAll(classReader.usedSubstances());
            ownSubstances.forEach(
                    own -> substances.find(own.key()).ifPresent(each -> used.add(each.code())));
            addRows(substances.rows(used), items, itemReader, root);
        }
        problems.throwIfAny();
        return new WorldDescription(
                text(root, "name"),
                text(root, "doc"),
                prototype,
                timing(root),
                age,
                laws,
                constants,
                camera,
                agents,
                rules,
                wholeNumber(root.get("frame"), "ruleSteps", Rules.DEFAULT_STEPS),
                items,
                forces,
                problems.warnings(),
                Places.of(
                        problems.file(),
                        itemReader.places(),
                        source.all("constants"),
                        root.get("agents").flatMap(node -> node.get("body"))),
                (int) wholeNumber(root.get("frame"), "threads", 1),
                cameras);
    }

    /**
     * Adds the rows of substances after the other items. A saved world has rows already, which it
     * keeps.
     */
    private void addRows(
            List<ItemDefinition> rows, List<ItemDefinition> items, ItemReader reader, Node root) {
        Map<String, String> kinds = new HashMap<>();
        items.forEach(item -> kinds.put(item.name(), item.kind()));
        for (ItemDefinition row : rows) {
            String kind = kinds.get(row.name());
            if (kind == null) {
                items.add(row);
                reader.places().add(Places.Place.of(root));
            } else if (!kind.equals(WorldPrototype.SUBSTANCE_PAIR)) {
                problems.add(
                        root,
                        "an item has the name `"
                                + row.name()
                                + "`, which the world needs for a substance; rename the item");
            }
        }
    }

    /**
     * Refuses declared properties that need more than {@link #MAX_NUMBERS} numbers for all items.
     */
    private void requireRoom(List<Node> properties, List<ItemDefinition> items) {
        if (properties.isEmpty()) {
            return;
        }
        Map<String, Long> rows =
                items.stream()
                        .collect(
                                Collectors.groupingBy(ItemDefinition::kind, Collectors.counting()));
        long numbers = 0;
        for (Node property : properties) {
            String kind = property.get("kind").flatMap(Node::text).orElse("");
            int components = PrototypeReader.components(property);
            long ofKind = rows.getOrDefault(kind, 0L);
            numbers += ofKind * components;
            if (numbers > MAX_NUMBERS) {
                problems.add(
                        property,
                        "the declared properties up to this one need "
                                + numbers
                                + " numbers for all items ("
                                + components
                                + " for each of "
                                + ofKind
                                + " items of kind "
                                + Node.shorten(kind)
                                + "), at most "
                                + MAX_NUMBERS
                                + "; declare fewer properties or components, or make fewer items");
                return;
            }
        }
    }

    private static String text(Node node, String key) {
        return node.get(key).flatMap(Node::text).orElse("");
    }

    private static Timing timing(Node root) {
        Optional<Node> frame = root.get("frame");
        return new Timing(
                (int) wholeNumber(frame, "rate", Timing.DEFAULT.framesPerSecond()),
                (int) wholeNumber(frame, "steps", Timing.DEFAULT.stepsPerFrame()));
    }

    private static long wholeNumber(Optional<Node> node, String key, long otherwise) {
        return node.flatMap(mapping -> mapping.get(key))
                .flatMap(Node::number)
                .map(Double::longValue)
                .orElse(otherwise);
    }

    private List<LawReference> laws(List<Node> nodes, PhysicsReader physics) {
        List<LawReference> laws = new ArrayList<>();
        Map<String, Node> byName = new HashMap<>();
        for (Node node : nodes) {
            Optional<Node> textNode = node.isMapping() ? node.get("text") : Optional.empty();
            Optional<Node> nameNode =
                    textNode.isPresent()
                            ? textNode
                            : node.isMapping() ? node.get("name") : Optional.of(node);
            if (node.isMapping() && node.get("name").isPresent() == textNode.isPresent()) {
                problems.add(
                        node,
                        node.label()
                                + ": found "
                                + (textNode.isPresent() ? "both" : "neither")
                                + ", expected one of `name` and `text`");
            }
            nameNode.flatMap(Node::text)
                    .map(given -> textNode.isPresent() ? nameInText(given) : given)
                    .ifPresent(
                            name -> {
                                Node first = byName.putIfAbsent(name, nameNode.get());
                                if (first != null) {
                                    problems.add(
                                            nameNode.get(),
                                            "duplicate law `"
                                                    + Node.shorten(name)
                                                    + "`, first "
                                                    + Problems.place(first, nameNode.get()));
                                }
                                VisibleName.fault(name)
                                        .ifPresent(
                                                fault ->
                                                        problems.add(
                                                                nameNode.get(),
                                                                "law `"
                                                                        + Node.shorten(name)
                                                                        + "` "
                                                                        + fault));
                                laws.add(
                                        law(
                                                name,
                                                textNode.flatMap(Node::text),
                                                node,
                                                Problems.place(nameNode.get()),
                                                physics));
                            });
        }
        return laws;
    }

    /**
     * Returns the name of the first law in a text. The physics engine reports the error later if
     * the text contains no law.
     */
    static String nameInText(String text) {
        Matcher name = FIRST_LAW.matcher(text);
        return name.find() ? name.group(1) : "text";
    }

    /**
     * Reads a law and converts its parameters to SI units. Does not check the names of the
     * parameters, because only the loaded law knows them.
     */
    private LawReference law(
            String name, Optional<String> text, Node law, String place, PhysicsReader physics) {
        return ParameterFile.reference(
                        name,
                        text,
                        law.get("parameters")
                                .<Collection<Node>>map(Node::children)
                                .orElse(List.of()),
                        place,
                        quantities,
                        physics,
                        problems)
                .withBudget(
                        Optional.of(law)
                                .filter(Node::isMapping)
                                .flatMap(mapping -> mapping.get("budget"))
                                .flatMap(new BudgetReader(quantities, problems)::read));
    }

    private AgentPolicy agents(Node node, ItemReader itemReader, BodyCheck check)
            throws WorldFileException {
        List<String> bodies = node.get("bodies").map(itemReader.names()::bodies).orElse(List.of());
        Optional<Node> body = node.get("body");
        return new AgentPolicy(
                bodies,
                body.isEmpty()
                        ? Optional.empty()
                        : Optional.of(itemReader.readTemplate(body.get())),
                places(node, check),
                (int) wholeNumber(Optional.of(node), "items", AgentPolicy.DEFAULT_ITEMS),
                (int) wholeNumber(Optional.of(node), "worldItems", AgentPolicy.DEFAULT_WORLD_ITEMS),
                (int) wholeNumber(Optional.of(node), "eventBytes", AgentPolicy.DEFAULT_EVENT_BYTES),
                (int)
                        wholeNumber(
                                Optional.of(node),
                                "worldEventBytes",
                                AgentPolicy.DEFAULT_WORLD_EVENT_BYTES),
                (int) wholeNumber(Optional.of(node), "most", AgentPolicy.DEFAULT_MOST));
    }

    private List<AgentPolicy.Place> places(Node agents, BodyCheck check) {
        var places = new ArrayList<AgentPolicy.Place>();
        for (Node node : agents.get("places").map(Node::children).orElse(List.of())) {
            quantities
                    .numbers(node, 3, METRE)
                    .ifPresent(
                            at -> {
                                check.checkPlace(node, at);
                                places.add(new AgentPolicy.Place(at[0], at[1], at[2]));
                            });
        }
        return places;
    }
}
