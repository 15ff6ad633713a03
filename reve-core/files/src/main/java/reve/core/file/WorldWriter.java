// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.frame.TimeBudget;
import reve.core.rule.Rule;
import reve.core.rule.Rules;
import reve.core.rule.SymbolSource;
import reve.core.unit.Unit;
import reve.core.world.FieldDescriptor;
import reve.core.world.ItemClass;
import reve.core.world.ItemDefinition;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.SymbolDescriptor;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.stream.Collectors;
import java.util.stream.Stream;

/**
 * Writer of a world as text of one world file. The same world always gives the same text. Reading
 * this text restores the world to the bit. The text contains no prefabs, repetitions or included
 * files, because they are expanded. Meshes and images stay separate files.
 */
public final class WorldWriter {
    /** Maximum number of forces in a world file, as the schema states it. */
    private static final int MAX_FORCES = 10_000;

    /** Maximum number of laws in a world file, as the schema states it. */
    public static final int MAX_LAWS = 64;

    /** Maximum number of classes, symbols and rules in one world file, as the schema states it. */
    static final int MAX_RULES = 256;

    private final WorldDescription world;
    private final ItemWriter items;

    /** The different expressions of actions, as {@link ActionReader} counts them. */
    private final Set<List<Object>> expressions = new HashSet<>();

    private WorldWriter(WorldDescription world) {
        this.world = world;
        this.items =
                new ItemWriter(
                        world.prototype(),
                        (parameters, text) -> expressions.add(List.of(parameters, text)));
    }

    /**
     * Returns the text of a world file.
     *
     * @throws IllegalArgumentException naming an item or property that a world file cannot express
     */
    public static String write(WorldDescription world) {
        return YamlWriter.write(new WorldWriter(world).tree());
    }

    private Map<String, Object> tree() {
        requireAtMost(MAX_LAWS, world.laws().size(), "laws");
        requireAtMost(MAX_RULES, world.rules().size(), "rules");
        requireAtMost(MAX_RULES, world.prototype().symbols().size(), "typed symbols");
        requireAtMost(MAX_RULES, world.prototype().classes().all().size(), "classes");
        requireAtMost(Expansion.MAX_ITEMS, world.items().size(), "items");
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("reve", YamlWriter.Numeral.of(WorldFile.FORMAT_VERSION));
        tree.put("name", world.name());
        if (!world.doc().isEmpty()) {
            tree.put("doc", world.doc());
        }
        tree.put("prototype", world.prototype().name());
        putIfAny(tree, "properties", properties());
        tree.put("frame", frame());
        putIfAny(tree, "laws", world.laws().stream().map(WorldWriter::law).toList());
        if (!constants().isEmpty()) {
            tree.put("constants", constants());
        }
        world.camera().ifPresent(camera -> tree.put("camera", camera(camera)));
        Map<String, Object> cameras = cameras();
        if (!cameras.isEmpty()) {
            tree.put("cameras", cameras);
        }
        if (!world.agents().equals(AgentPolicy.none())) {
            tree.put("agents", agents());
        }
        if (!world.prototype().classes().isEmpty()) {
            tree.put("classes", classes());
        }
        if (!world.prototype().symbols().isEmpty()) {
            tree.put("symbols", symbols());
        }
        if (!world.rules().isEmpty()) {
            tree.put("rules", rules());
        }
        putIfAny(tree, "items", items());
        requireAtMost(
                ActionReader.MAX_EXPRESSIONS,
                expressions.size(),
                "different conditions and values in its actions");
        putIfAny(tree, "forces", forces());
        return tree;
    }

    /**
     * Returns the trees of the items. A world has a property on demand only if one of its items
     * sets it. The first item of a kind therefore explicitly sets a property on demand that is 0 at
     * all items.
     */
    private List<Map<String, Object>> items() {
        List<Map<String, Object>> trees = world.items().stream().map(items::tree).toList();
        for (PropertyDescriptor property : world.prototype().propertiesOnDemand()) {
            if (world.prototype().properties().contains(property)) {
                List<Map<Object, Object>> aspects = physics(trees, property.kind());
                if (aspects.stream().noneMatch(one -> one.containsKey(property.name()))) {
                    aspects.stream()
                            .findFirst()
                            .ifPresent(first -> first.put(property.name(), zero(property)));
                }
            }
        }
        return trees;
    }

    /** Returns the physics aspects of the items of a kind. */
    private List<Map<Object, Object>> physics(List<Map<String, Object>> trees, String kind) {
        List<Map<Object, Object>> aspects = new ArrayList<>();
        for (int i = 0; i < trees.size(); i++) {
            if (world.items().get(i).kind().equals(kind)
                    && trees.get(i).get("physics") instanceof Map<?, ?> physics) {
                @SuppressWarnings("unchecked") // keys are names of properties, which are texts
                var aspect = (Map<Object, Object>) physics;
                aspects.add(aspect);
            }
        }
        return aspects;
    }

    private static Object zero(PropertyDescriptor property) {
        return ItemWriter.quantity(property.type(), new double[property.components()]);
    }

    private List<Object> forces() {
        if (world.forces().size() > MAX_FORCES) {
            throw new IllegalArgumentException(
                    "world "
                            + world.name()
                            + " has "
                            + world.forces().size()
                            + " forces that still act, of which a world file holds "
                            + MAX_FORCES
                            + ": save it when fewer do");
        }
        List<Object> forces = new ArrayList<>();
        for (LastingForce force : world.forces()) {
            Map<String, Object> tree = new LinkedHashMap<>();
            tree.put("item", force.item());
            tree.put("force", force.newtons().stream().map(YamlWriter.Numeral::of).toList());
            tree.put("frames", YamlWriter.Numeral.of((double) force.frames()));
            forces.add(tree);
        }
        return forces;
    }

    /** Refuses a text that exceeds a limit. Such a text could be written, but not read again. */
    private void requireAtMost(int most, int count, String what) {
        if (count > most) {
            throw new IllegalArgumentException(
                    "world "
                            + world.name()
                            + " has "
                            + count
                            + " "
                            + what
                            + ", of which a world file holds "
                            + most);
        }
    }

    private static void putIfAny(Map<String, Object> tree, String key, List<?> values) {
        if (!values.isEmpty()) {
            tree.put(key, values);
        }
    }

    private Map<String, Object> classes() {
        Map<String, Object> classes = new LinkedHashMap<>();
        for (ItemClass each : world.prototype().classes().all()) {
            Map<String, Object> tree = new LinkedHashMap<>();
            if (!each.parent().equals(WorldPrototype.BODY)) {
                tree.put("is", each.parent());
            }
            if (!each.doc().isEmpty()) {
                tree.put("doc", each.doc());
            }
            if (!each.symbols().isEmpty()) {
                tree.put("semantic", ItemWriter.symbols(each.symbols()));
            }
            Map<String, Object> physics = properties(each);
            if (!physics.isEmpty()) {
                tree.put("physics", physics);
            }
            classes.put(each.name(), tree);
        }
        return classes;
    }

    private Map<String, Object> properties(ItemClass itemClass) {
        String kind = world.prototype().classes().kind(itemClass.name()).orElseThrow();
        Map<String, Object> physics = new LinkedHashMap<>();
        itemClass
                .properties()
                .forEach(
                        (property, values) ->
                                physics.put(
                                        property,
                                        ItemWriter.quantity(
                                                world.prototype()
                                                        .find(kind, property)
                                                        .map(PropertyDescriptor::type)
                                                        .orElse(ScalarType.F64),
                                                values.stream()
                                                        .mapToDouble(Double::doubleValue)
                                                        .toArray())));
        return physics;
    }

    private Map<String, Object> symbols() {
        Map<String, Object> symbols = new LinkedHashMap<>();
        for (SymbolDescriptor symbol : world.prototype().symbols()) {
            Map<String, Object> tree = new LinkedHashMap<>();
            tree.put("type", symbol.type().name().toLowerCase(Locale.ROOT));
            if (!symbol.unit().equals(Unit.ONE)) {
                tree.put("unit", symbol.unit().symbol());
            }
            if (!symbol.doc().isEmpty()) {
                tree.put("doc", symbol.doc());
            }
            symbols.put(symbol.name(), tree);
        }
        return symbols;
    }

    private Map<String, Object> rules() {
        Map<String, Object> rules = new LinkedHashMap<>();
        world.rules().forEach(rule -> rules.put(rule.symbol(), rule(rule)));
        return rules;
    }

    /** Returns a rule in the form of a world file: a text, or a map of texts. */
    static Object rule(Rule rule) {
        Map<String, Object> tree = new LinkedHashMap<>();
        switch (rule.source()) {
            case SymbolSource.Formula formula -> tree.put("is", formula.expression().text());
            case SymbolSource.Provided provided ->
                    tree.put(ProviderReader.JAVA, provided.provider().name());
        }
        if (!rule.kind().equals(WorldPrototype.BODY)) {
            tree.put("kind", rule.kind());
        }
        rule.itemClass().ifPresent(wanted -> tree.put("class", wanted));
        if (!rule.doc().isEmpty()) {
            tree.put("doc", rule.doc());
        }
        boolean isBare = tree.size() == 1 && rule.source() instanceof SymbolSource.Formula;
        return isBare ? tree.getOrDefault("is", "") : tree;
    }

    private List<Object> properties() {
        WorldPrototype prototype = world.prototype();
        int standard = WorldPrototype.standard(prototype.name()).properties().size();
        List<Object> own = new ArrayList<>();
        for (PropertyDescriptor property :
                prototype.properties().subList(standard, prototype.properties().size())) {
            if (!prototype.isOfJoints(property)
                    && !prototype.propertiesOnDemand().contains(property)) {
                own.add(property(property));
            }
        }
        prototype.fields().forEach(field -> own.add(field(field)));
        return own;
    }

    private static Map<String, Object> field(FieldDescriptor field) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("name", field.name());
        tree.put("kind", WorldPrototype.WORLD);
        tree.put("type", PrototypeReader.FIELD);
        if (field.components() != 1) {
            tree.put("components", YamlWriter.Numeral.of(field.components()));
        }
        if (!field.unit().equals(Unit.ONE)) {
            tree.put("unit", field.unit().symbol());
        }
        if (!field.doc().isEmpty()) {
            tree.put("doc", field.doc());
        }
        return tree;
    }

    private Map<String, Object> property(PropertyDescriptor property) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("name", property.name());
        tree.put("kind", property.kind());
        property.refersTo()
                .ifPresentOrElse(
                        kind -> tree.put(PrototypeReader.REFERS_TO, kind),
                        () -> type(property).ifPresent(type -> tree.put("type", type)));
        if (property.components() != 1) {
            tree.put("components", YamlWriter.Numeral.of(property.components()));
        }
        if (!property.unit().equals(Unit.ONE)) {
            tree.put("unit", property.unit().symbol());
        }
        if (Double.isFinite(property.minimum())) {
            tree.put("min", YamlWriter.Numeral.of(property.minimum()));
        }
        if (property.accumulated()) {
            tree.put(PrototypeReader.ACCESS, PrototypeReader.ACCUMULATE);
        }
        if (!property.doc().isEmpty()) {
            tree.put("doc", property.doc());
        }
        return tree;
    }

    /**
     * Returns the name of a property's type for the file. Returns empty if the type is the default,
     * which is the prototype's real type.
     */
    private Optional<String> type(PropertyDescriptor property) {
        if (property.type() == world.prototype().realType()) {
            return Optional.empty();
        }
        return switch (property.type()) {
            case I32 -> Optional.of("i32");
            case U32 -> Optional.of("u32");
            case F32, F64, REF ->
                    throw new IllegalArgumentException(
                            "property "
                                    + property.name()
                                    + " is of type "
                                    + property.type()
                                    + ", which no world file of prototype "
                                    + world.prototype().name()
                                    + " can declare");
        };
    }

    private Map<String, Object> frame() {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("rate", YamlWriter.Numeral.of(world.timing().framesPerSecond()));
        tree.put("steps", YamlWriter.Numeral.of(world.timing().stepsPerFrame()));
        if (world.age() > 0) {
            tree.put("age", YamlWriter.Numeral.of((double) world.age()));
        }
        putUnless(tree, "threads", world.threads(), 1);
        putUnless(tree, "ruleSteps", (int) world.ruleSteps(), (int) Rules.DEFAULT_STEPS);
        return tree;
    }

    private static Object law(LawReference law) {
        if (law.parameters().isEmpty() && law.text().isEmpty() && law.budget().isEmpty()) {
            return law.name();
        }
        Map<String, Object> parameters = new LinkedHashMap<>();
        law.parameters()
                .forEach((name, value) -> parameters.put(name, YamlWriter.Numeral.of(value)));
        Map<String, Object> tree = new LinkedHashMap<>();
        law.text()
                .ifPresentOrElse(
                        text -> tree.put("text", new YamlWriter.Lines(text)),
                        () -> tree.put("name", law.name()));
        if (!parameters.isEmpty()) {
            tree.put("parameters", parameters);
        }
        law.budget().ifPresent(budget -> tree.put("budget", budget(budget)));
        return tree;
    }

    private static Map<String, Object> budget(TimeBudget budget) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("time", YamlWriter.Numeral.of(budget.nanoseconds() / 1e9));
        tree.put("frames", YamlWriter.Numeral.of((double) budget.frames()));
        tree.put("then", budget.response().text());
        tree.put("every", YamlWriter.Numeral.of((double) budget.every()));
        return tree;
    }

    private Map<String, Object> constants() {
        Map<String, Object> tree = new LinkedHashMap<>();
        for (PropertyDescriptor property : world.prototype().properties()) {
            List<Double> values = world.constants().get(property.name());
            if (property.kind().equals(WorldPrototype.WORLD) && values != null) {
                double[] numbers = values.stream().mapToDouble(Double::doubleValue).toArray();
                if (!ItemWriter.isZero(numbers)) {
                    tree.put(property.name(), ItemWriter.quantity(property.type(), numbers));
                }
            }
        }
        return tree;
    }

    private static Map<String, Object> camera(CameraDescription camera) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("eye", ItemWriter.quantity(ScalarType.F64, camera.eye()));
        tree.put("target", ItemWriter.quantity(ScalarType.F64, camera.target()));
        tree.put("up", ItemWriter.quantity(ScalarType.F64, camera.up()));
        tree.put("fov", YamlWriter.Numeral.of(camera.verticalFovRadians()));
        return tree;
    }

    /** Returns the cameras that need no item or whose items are still in the world. */
    private Map<String, Object> cameras() {
        Map<String, Object> cameras = new LinkedHashMap<>();
        if (world.cameras().isEmpty()) {
            return cameras;
        }
        Set<String> names =
                world.items().stream().map(ItemDefinition::name).collect(Collectors.toSet());
        for (NamedCamera camera : world.cameras()) {
            boolean isWhole =
                    Stream.of(camera.follow(), camera.lookAt())
                            .flatMap(Optional::stream)
                            .allMatch(names::contains);
            if (isWhole) {
                cameras.put(camera.name(), camera(camera));
            }
        }
        return cameras;
    }

    private static Map<String, Object> camera(NamedCamera camera) {
        Map<String, Object> tree = new LinkedHashMap<>();
        camera.follow().ifPresent(item -> tree.put("follow", item));
        if (camera.turning()) {
            tree.put("turning", true);
        }
        camera.lookAt().ifPresent(item -> tree.put("lookAt", item));
        List<Object> frames = new ArrayList<>();
        for (NamedCamera.Key key : camera.keys()) {
            Map<String, Object> frame = new LinkedHashMap<>();
            frame.put("time", YamlWriter.Numeral.of(key.timeSeconds()));
            frame.putAll(camera(key.view()));
            if (camera.lookAt().isPresent()) {
                frame.remove("target");
            }
            frames.add(frame);
        }
        tree.put("keyframes", frames);
        return tree;
    }

    private Map<String, Object> agents() {
        Map<String, Object> tree = new LinkedHashMap<>();
        putIfAny(tree, "bodies", world.agents().bodies());
        world.agents().template().ifPresent(body -> tree.put("body", items.template(body)));
        putIfAny(
                tree,
                "places",
                world.agents().places().stream()
                        .map(
                                place ->
                                        ItemWriter.quantity(
                                                ScalarType.F64,
                                                new double[] {place.x(), place.y(), place.z()}))
                        .toList());
        AgentPolicy agents = world.agents();
        putUnless(tree, "items", agents.items(), AgentPolicy.DEFAULT_ITEMS);
        putUnless(tree, "worldItems", agents.worldItems(), AgentPolicy.DEFAULT_WORLD_ITEMS);
        putUnless(tree, "eventBytes", agents.eventBytes(), AgentPolicy.DEFAULT_EVENT_BYTES);
        putUnless(
                tree,
                "worldEventBytes",
                agents.worldEventBytes(),
                AgentPolicy.DEFAULT_WORLD_EVENT_BYTES);
        putUnless(tree, "most", agents.most(), AgentPolicy.DEFAULT_MOST);
        return tree;
    }

    private static void putUnless(Map<String, Object> tree, String key, int value, int otherwise) {
        if (value != otherwise) {
            tree.put(key, YamlWriter.Numeral.of(value));
        }
    }
}
