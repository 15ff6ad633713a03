// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.mesh.Assets;
import reve.core.mesh.WorldFolder;
import reve.core.rule.Rule;
import reve.core.rule.Scope;
import reve.core.text.Visible;
import reve.core.world.ActionRefused;
import reve.core.world.ItemDefinition;
import reve.core.world.WorldPrototype;

import tools.jackson.databind.json.JsonMapper;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.Consumer;

/**
 * Reader of edits, which are changes of a running world. Their texts are parts of world files in
 * JSON or YAML. The texts cannot refer to files. For any thread.
 */
public final class EditReader {
    private static final Set<String> CHANGEABLE =
            Set.of("name", "parent", "physical", "physics", "semantic", "access");
    private final WorldPrototype prototype;

    /** Creates a reader for a world of this prototype. */
    public EditReader(WorldPrototype prototype) {
        this.prototype = prototype;
    }

    /**
     * The numbers of items, values, formulas and expressions of actions that the changes of one
     * message may still add. For one thread.
     */
    public static final class Room {
        /**
         * Maximum number of different expressions in the actions of one message. The world waits
         * while they are compiled, which takes about a millisecond each.
         */
        static final int MAX_EXPRESSIONS = 250;

        private final Expansion.Limits limits = Expansion.Limits.ofMessage();
        private final Allowance expressions = new Allowance(MAX_EXPRESSIONS);
    }

    /**
     * Reads items to add.
     *
     * @param text a mapping with {@code items} and, if the items are {@code like} prefabs, {@code
     *     prefabs}
     * @param room remaining limits of the message, which the items, values and formulas reduce
     * @throws WorldFileException with all problems of the text
     */
    public WorldEdit.Add add(String text, Room room) throws WorldFileException {
        var problems = new Problems("add");
        Node part = YamlReader.read(text, problems, new Allowance(YamlReader.MAX_VALUES));
        SchemaCheck.checkPart(part, problems);
        for (Node value : part.children()) {
            if (!value.key().equals("items") && !value.key().equals("prefabs")) {
                problems.addAtKey(
                        value, "`" + value.key() + "` cannot be added; expected items or prefabs");
            }
        }
        problems.throwIfAny();
        WorldSource source =
                new WorldSource(part, List.of(part), new SourceFiles(WorldFolder.none(), "add"));
        var expansion = new Expansion(source, room.limits, problems);
        PhysicsReader physics = physics(problems);
        ItemReader reader = reader(expansion::complete, physics, room, problems);
        reader.names().permitOthers();
        List<ItemDefinition> items =
                new ArrayList<>(reader.readAll(source.all("items"), expansion));
        problems.throwIfAny();
        room.limits.requireCharacters(items, problems);
        items.addAll(Substances.shipped().rowsWithAny(physics.usedSubstances()));
        return new WorldEdit.Add(items);
    }

    /**
     * Reads a change of an item.
     *
     * @param item name of the item
     * @param kind kind of the item
     * @param text a mapping of the values that change, in the form of an item; null removes a value
     * @throws WorldFileException with all problems of the text
     */
    public WorldEdit change(String item, String kind, String text) throws WorldFileException {
        return change(item, kind, text, new Room());
    }

    /**
     * Reads a change of an item, which is one of several changes of a message.
     *
     * @param room remaining limits of the message
     */
    public WorldEdit change(String item, String kind, String text, Room room)
            throws WorldFileException {
        var problems = new Problems("change");
        Node given = YamlReader.read(text, problems, new Allowance(YamlReader.MAX_VALUES));
        problems.throwIfAny();
        List<String> set = new ArrayList<>();
        List<String> cleared = new ArrayList<>();
        Node values = split(given, set, cleared, problems);
        if (set.remove("parent")) {
            // The parent is the last value that is set. An item with a mass cannot be attached, so
            // a new mass of 0 must be set before the parent.
            set.add("parent");
        }
        problems.throwIfAny();
        Map<String, Node> fields = new LinkedHashMap<>();
        for (Node value : values.children()) {
            fields.put(value.key(), value);
        }
        Node named = values.withValue(fields);
        if (named.get("name").isEmpty()) {
            new Node.Slot(named, "name", given.line(), given.column())
                    .fill(given.line(), given.column(), item);
        }
        SchemaCheck.checkItem(named, problems);
        problems.throwIfAny();
        ItemDefinition definition =
                reader(node -> node, physics(problems), room, problems).readChange(named, kind);
        problems.throwIfAny();
        return new WorldEdit.Change(item, definition, set, cleared);
    }

    /**
     * Divides the keys of a change into {@code set} and {@code cleared}. Returns the values to set.
     */
    private static Node split(
            Node given, List<String> set, List<String> cleared, Problems problems) {
        Map<String, Node> fields = new LinkedHashMap<>();
        for (Node value : given.children()) {
            String key = value.key();
            if (!given.isMapping() || !CHANGEABLE.contains(key)) {
                problems.addAtKey(
                        value,
                        "`"
                                + key
                                + "` of an item cannot be changed; expected name, parent, physical,"
                                + " physics, semantic or access");
            } else if (value.isNothing()) {
                clear(key, value, cleared, problems);
            } else if (value.isMapping()) {
                fields.put(key, splitAspect(key, value, set, cleared, problems));
            } else {
                set.add(key);
                fields.put(key, value);
            }
        }
        if (given.children().isEmpty()) {
            problems.add(given, "to: found nothing to change");
        }
        return given.isMapping() ? given.withValue(fields) : given;
    }

    private static Node splitAspect(
            String aspect, Node values, List<String> set, List<String> cleared, Problems problems) {
        Map<String, Node> left = new LinkedHashMap<>();
        for (Node value : values.children()) {
            String key = aspect + "." + value.key();
            if (value.isNothing()) {
                clear(key, value, cleared, problems);
                continue;
            }
            left.put(value.key(), value);
            String what =
                    aspect.equals("physical") && PhysicalReader.SHAPE_KEYS.contains(value.key())
                            ? "physical.shape"
                            : key;
            if (key.equals("physics.density")) {
                set.add("physics.mass");
                set.add("physics.inertia");
            } else if (!set.contains(what)) {
                set.add(what);
            }
        }
        return values.withValue(left);
    }

    private static void clear(String key, Node value, List<String> cleared, Problems problems) {
        if (key.equals("parent")
                || key.equals("physics")
                || key.equals("physical.material")
                || key.startsWith("semantic.")
                || key.startsWith("access.")) {
            cleared.add(key);
        } else {
            problems.addAtKey(
                    value,
                    key
                            + ": cannot be removed; null removes a parent, the whole physics, a"
                            + " material, a symbol or an action");
        }
    }

    private PhysicsReader physics(Problems problems) {
        return new PhysicsReader(prototype, Set.of(), Doubts.REFUSED, problems);
    }

    private ItemReader reader(
            ItemReader.Completion completion, PhysicsReader physics, Room room, Problems problems) {
        var reader =
                new ItemReader(
                        prototype,
                        physics,
                        new Assets(WorldFolder.none()),
                        (node, path) -> path,
                        completion,
                        Doubts.REFUSED,
                        problems);
        reader.shareExpressions(room.expressions);
        return reader;
    }

    /** Refuses too many rules before any of them is compiled, which takes most of the time. */
    private static void requireRoom(Set<String> symbols, Map<String, Optional<String>> changes)
            throws ActionRefused {
        Set<String> after = new HashSet<>(symbols);
        changes.forEach(
                (symbol, rule) -> {
                    if (rule.isPresent()) {
                        after.add(symbol);
                    } else {
                        after.remove(symbol);
                    }
                });
        if (after.size() > WorldWriter.MAX_RULES && after.size() > symbols.size()) {
            throw new ActionRefused(
                    WorldEdit.REFUSED,
                    "the world would have "
                            + after.size()
                            + " rules, expected at most "
                            + WorldWriter.MAX_RULES);
        }
    }

    /**
     * Returns the rules after some of them are replaced, added at the end, or removed.
     *
     * @param changes changed rules, by the symbol that each rule computes; each is a rule in the
     *     form of a world file (an expression, or a mapping with {@code is}), and an empty Optional
     *     removes the rule
     * @throws ActionRefused naming the first rule that is wrong
     */
    public List<Rule> rules(List<Rule> rules, Map<String, Optional<String>> changes)
            throws ActionRefused {
        Map<String, Rule> changed = new LinkedHashMap<>();
        rules.forEach(rule -> changed.put(rule.symbol(), rule));
        requireRoom(changed.keySet(), changes);
        Map<String, Scope> scopes = new HashMap<>();
        for (Map.Entry<String, Optional<String>> change : changes.entrySet()) {
            String name = change.getKey();
            if (change.getValue().isEmpty()) {
                changed.remove(name);
                continue;
            }
            try {
                changed.put(name, rule(name, change.getValue().get(), scopes));
            } catch (WorldFileException invalid) {
                throw refused(name, invalid.problems().getFirst().message());
            }
        }
        List<Rule> all = List.copyOf(changed.values());
        for (RuleReader.Misplaced misplaced : RuleReader.misplaced(all)) {
            for (Rule rule : List.of(misplaced.rule(), misplaced.later())) {
                if (changes.containsKey(rule.symbol())) {
                    throw refused(rule.symbol(), misplaced.message());
                }
            }
        }
        return all;
    }

    private static ActionRefused refused(String rule, String reason) {
        return new ActionRefused(WorldEdit.REFUSED, named(rule) + reason);
    }

    private static String named(String rule) {
        return "rule " + Visible.shortened(rule) + ": ";
    }

    /**
     * Returns the rules of a world file after the changes that an earlier run of the world made.
     * Omits a changed rule that does not fit the world, for example because its plugin is missing.
     *
     * @param problems receives one message for each omitted rule
     */
    public List<Rule> rules(List<Rule> rules, RuleChanges changes, Consumer<String> problems) {
        Map<String, Rule> now = new LinkedHashMap<>();
        rules.forEach(rule -> now.put(rule.symbol(), rule));
        Map<String, Scope> scopes = new HashMap<>();
        for (RuleChanges.Change change : changes.changes()) {
            String symbol = change.symbol();
            if (change.rule().isEmpty()) {
                now.remove(symbol);
                continue;
            }
            try {
                Rule changed = rule(symbol, change.rule().get(), scopes);
                if (change.isLast()) {
                    now.remove(symbol);
                }
                now.put(symbol, changed);
            } catch (WorldFileException invalid) {
                problems.accept(omitted(symbol, invalid.problems().getFirst().message()));
            }
        }
        Set<String> changed = changes.symbols();
        for (RuleReader.Misplaced misplaced : RuleReader.misplaced(List.copyOf(now.values()))) {
            Rule wrong =
                    changed.contains(misplaced.rule().symbol())
                            ? misplaced.rule()
                            : misplaced.later();
            if (now.remove(wrong.symbol(), wrong)) {
                problems.accept(omitted(wrong.symbol(), misplaced.message()));
            }
        }
        return List.copyOf(now.values());
    }

    private static String omitted(String symbol, String reason) {
        return named(symbol)
                + reason
                + "; the rule was changed while the world ran, and the world continues without this"
                + " change";
    }

    private Rule rule(String name, String text, Map<String, Scope> scopes)
            throws WorldFileException {
        var problems = new Problems("rule");
        Node part =
                YamlReader.read(
                        "{\"rules\":{"
                                + JsonMapper.shared().writeValueAsString(name)
                                + ":"
                                + text
                                + "}}",
                        problems,
                        new Allowance(YamlReader.MAX_VALUES));
        SchemaCheck.checkPart(part, problems);
        problems.throwIfAny();
        Node node = part.get("rules").orElseThrow().children().iterator().next();
        Optional<Rule> rule = new RuleReader(problems).readChange(node, prototype, scopes);
        problems.throwIfAny();
        return rule.orElseThrow();
    }
}
