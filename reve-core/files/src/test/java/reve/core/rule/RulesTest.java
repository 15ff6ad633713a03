// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.derive.BoundingBoxes;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.unit.Unit;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.Shape;
import reve.core.world.SymbolDescriptor;
import reve.core.world.SymbolType;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.Collections;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.stream.IntStream;

class RulesTest {
    private static final WorldPrototype PROTOTYPE =
            WorldPrototype.standard("si-f64")
                    .extendedBy(
                            List.of(
                                    new PropertyDescriptor(
                                            "temperature",
                                            "body",
                                            ScalarType.F64,
                                            1,
                                            Unit.parse("K"),
                                            Optional.empty(),
                                            "")))
                    .withSymbols(
                            List.of(
                                    new SymbolDescriptor(
                                            "pace", SymbolType.NUMBER, Unit.parse("km/h"), "")));

    /** An expression of more than 100 steps. */
    private static final String DEAR =
            "[1,2,3,4,5].all(a,[1,2,3,4,5].all(b,physics.temperature > -1.0e9))";

    private final OffHeapArena arena = new OffHeapArena();
    private final World world = new World("test", PROTOTYPE, arena);

    @AfterEach
    void free() {
        arena.close();
    }

    private Item body(String name, double temperature) {
        return world.add(ItemDefinition.named(name).physics("temperature", temperature).build());
    }

    private Rules rules(String... symbolsAndExpressions) throws ExpressionException {
        Rule[] rules = new Rule[symbolsAndExpressions.length / 2];
        Scope scope = Scope.ofItem(PROTOTYPE, "body");
        for (int i = 0; i < rules.length; i++) {
            rules[i] =
                    new Rule(
                            symbolsAndExpressions[2 * i],
                            "body",
                            Optional.empty(),
                            scope.compile(symbolsAndExpressions[2 * i + 1]),
                            "");
        }
        return new Rules(world, List.of(rules), Rules.DEFAULT_STEPS);
    }

    private Rules sharing(long steps, String... symbolsAndExpressions) throws ExpressionException {
        List<Rule> rules = new ArrayList<>();
        for (int i = 0; i < symbolsAndExpressions.length; i += 2) {
            rules.add(
                    new Rule(
                            symbolsAndExpressions[i],
                            "body",
                            Optional.empty(),
                            Scope.ofItem(PROTOTYPE, "body").compile(symbolsAndExpressions[i + 1]),
                            ""));
        }
        return new Rules(world, rules, steps, steps);
    }

    private List<Item> bodies(int count) {
        return IntStream.range(0, count).mapToObj(i -> body("b" + i, i)).toList();
    }

    private static List<Object> all(List<Item> items, String symbol) {
        return items.stream().map(item -> of(item, symbol)).toList();
    }

    private static Object of(Item item, String symbol) {
        return item.semantic().get(symbol).orElse("none");
    }

    @Test
    void symbolFollowsWhatItIsDerivedFrom() throws Exception {
        Item pot = body("pot", 300);
        Rules rules = rules("hot", "physics.temperature > 350");

        rules.update(1);
        assertThat(of(pot, "hot")).isEqualTo(false);
        pot.physics().set("temperature", 360);
        rules.update(2);
        assertThat(of(pot, "hot")).isEqualTo(true);
        assertThat(pot.semantic().symbols()).containsEntry("hot", true);
        assertThat(world.changes()).noneMatch(change -> change.toString().contains("hot"));
    }

    @Test
    void sceneryGetsNoSymbolThatReadsPhysics() throws Exception {
        Item wall = world.add(ItemDefinition.named("wall").build());
        Rules rules = rules("hot", "physics.temperature > 350", "named", "item.name");

        rules.update(1);

        assertThat(of(wall, "hot")).isEqualTo("none");
        assertThat(of(wall, "named")).isEqualTo("wall");
        assertThat(world.events()).isEmpty();
        wall.physics().set("temperature", 400);
        rules.update(2);
        assertThat(of(wall, "hot")).isEqualTo(true);
        wall.physics().clear();
        rules.update(3);
        assertThat(of(wall, "hot")).isEqualTo("none");
    }

    @Test
    void ruleSeesWhatThoseBeforeItGaveInTheSameFrame() throws Exception {
        Item pot = body("pot", 400);
        Rules rules =
                rules(
                        "hot",
                        "physics.temperature > 350",
                        "warning",
                        "semantic.hot ? 'careful' : 'fine'");

        rules.update(1);
        assertThat(of(pot, "warning")).isEqualTo("careful");
        pot.physics().set("temperature", 300);
        rules.update(2);
        assertThat(of(pot, "warning")).isEqualTo("fine");
    }

    @Test
    void ruleIsForItemsOfItsClassOnly() throws Exception {
        Item pot = body("pot", 400);
        Item cup = body("cup", 400);
        pot.semantic().set("class", "pot");
        Rules rules =
                new Rules(
                        world,
                        List.of(
                                new Rule(
                                        "hot",
                                        "body",
                                        Optional.of("pot"),
                                        Scope.ofItem(PROTOTYPE, "body")
                                                .compile("physics.temperature > 350"),
                                        "")),
                        Rules.DEFAULT_STEPS);

        rules.update(1);
        assertThat(of(pot, "hot")).isEqualTo(true);
        assertThat(of(cup, "hot")).isEqualTo("none");
        pot.semantic().set("class", "vase");
        rules.update(2);
        assertThat(of(pot, "hot")).isEqualTo("none");
    }

    @Test
    void theVolumeFollowsTheShape() throws Exception {
        Item thing = world.add(ItemDefinition.named("thing").build());
        Rules rules = rules("litres", "1000.0 * physical.volume");
        long frame = 0;
        Shape tetrahedron =
                Shape.mesh(
                        new float[] {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1},
                        new int[] {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3});
        Map<Shape, Double> litres = new LinkedHashMap<>();
        litres.put(Shape.sphere(0.5), 1000 * 4 / 3.0 * Math.PI * 0.125);
        litres.put(Shape.box(1, 2, 3), 6000.0);
        litres.put(Shape.box(1, 2, 4), 8000.0);
        litres.put(Shape.cylinder(0.5, 2), 1000 * Math.PI * 0.5);
        litres.put(Shape.plane(3, 3), 0.0);
        litres.put(tetrahedron, 1000 / 6.0);
        litres.put(Shape.none(), 0.0);
        for (Map.Entry<Shape, Double> each : litres.entrySet()) {
            thing.physical().setShape(each.getKey());
            rules.update(++frame);
            assertThat((double) of(thing, "litres"))
                    .as("%s", each.getKey())
                    .isCloseTo(each.getValue(), within(1e-9));
        }
        assertThat(world.events()).isEmpty();
    }

    @Test
    void aBodyIsMovableWhileItHasAMass() throws Exception {
        Item thing = world.add(ItemDefinition.named("thing").build());
        Item other = body("other", 300);
        Rules rules = rules("movable", "physical.movable");

        rules.update(1);
        assertThat(of(thing, "movable")).isEqualTo(false);
        assertThat(of(other, "movable")).isEqualTo(false);
        thing.physics().set("mass", 2);
        rules.update(2);
        assertThat(of(thing, "movable")).isEqualTo(true);
        thing.physics().clear();
        other.physics().set("mass", 1);
        rules.update(3);
        assertThat(of(thing, "movable")).isEqualTo(false);
        assertThat(of(other, "movable")).isEqualTo(true);
    }

    @Test
    void ownSymbolHidesThatOfARule() throws Exception {
        Item pot = body("pot", 400);
        pot.semantic().set("hot", "perhaps");
        Rules rules = rules("hot", "physics.temperature > 350");

        rules.update(1);
        assertThat(of(pot, "hot")).isEqualTo("perhaps");
        pot.semantic().remove("hot");
        assertThat(of(pot, "hot")).isEqualTo(true);
    }

    @Test
    void ruleThatGivesNothingIsToldOnceAndHarmsNothing() throws Exception {
        Item one = body("one", 0);
        Item two = body("two", 0);
        Rules rules = rules("inverse", "1.0 / physics.temperature", "always", "true");

        rules.update(1);
        rules.update(2);

        assertThat(of(one, "inverse")).isEqualTo("none");
        assertThat(of(two, "always")).isEqualTo(true);
        assertThat(world.events())
                .singleElement()
                .satisfies(
                        event -> {
                            assertThat(event.type()).isEqualTo("fault");
                            assertThat(event.fields()).containsEntry("source", "rule inverse");
                            assertThat(event.fields().get("message").toString())
                                    .contains("item one", "1.0 / physics.temperature", "Infinity");
                        });
        one.physics().set("temperature", 4);
        rules.update(3);
        assertThat(of(one, "inverse")).isEqualTo(0.25);
    }

    @Test
    void aListInAListIsRefusedInWordsOfTheWorldFile() throws Exception {
        body("pot", 1);
        rules("nested", "[1, 2].map(x, [x, x])").update(1);

        assertThat(world.events().getFirst().fields().get("message").toString())
                .contains(
                        "nested", "is a list in a list, expected text, truth, a number or a list");
    }

    @Test
    void numberIsKeptInTheUnitThatIsDeclaredForItsSymbol() throws Exception {
        Item car = world.add(ItemDefinition.named("car").physics("velocity", 10, 0, 0).build());

        rules("pace", "norm(physics.velocity)").update(1);

        assertThat(of(car, "pace")).isEqualTo(10 / Unit.parse("km/h").scale());
    }

    @Test
    void itemsThatARuleReadsAboutAreFoundWhereTheyAre() throws Exception {
        Item neighbour = world.add(ItemDefinition.named("here").at(1, 0, 0).build());
        Rules rules = rules("east", "semantic.location[0] > 0 && item.kind == 'body'");

        rules.update(1);
        assertThat(of(neighbour, "east")).isEqualTo(true);
        neighbour.physical().setLocation(-1, 0, 0);
        rules.update(2);
        assertThat(of(neighbour, "east")).isEqualTo(false);
    }

    @Test
    void standardSymbolsAreNotGivenByRules() {
        for (String symbol : List.of("name", "class", "near")) {
            assertThatIllegalArgumentException()
                    .isThrownBy(() -> rules(symbol, "'x'"))
                    .withMessageContaining(symbol)
                    .withMessageContaining("standard");
        }
    }

    @Test
    void itemsThatAreLeftAreEvaluatedInTheNextFrames() throws Exception {
        List<Item> items = bodies(10);
        Rules rules =
                sharing(
                        1000,
                        "cheap",
                        "physics.temperature >= 0.0",
                        "dear",
                        DEAR,
                        "last",
                        "semantic.dear ? 'x' : 'y'");

        int frames = 0;
        while (all(items, "last").contains("none")) {
            long before = all(items, "dear").stream().filter("none"::equals).count();
            rules.update(++frames);
            long after = all(items, "dear").stream().filter("none"::equals).count();
            assertThat(before - after).isBetween(1L, 4L); // an evaluation takes some 300 steps
            assertThat(all(items, "cheap")).containsOnly(true);
        }
        assertThat(frames).isBetween(3, 10);
        assertThat(all(items, "dear")).containsOnly(true);
        assertThat(all(items, "last")).containsOnly("x");
    }

    /**
     * Each item uses a step, although it needs no evaluation, because the rule reads a relation.
     */
    @Test
    void visitsOfItemsCountAsSteps() throws Exception {
        List<Item> items = bodies(1500);
        Rule crowded =
                new Rule(
                        "crowded",
                        "body",
                        Optional.of("person"),
                        Scope.ofItem(PROTOTYPE, "body").compile("size(semantic.near) > 3"),
                        "");
        Rule named =
                new Rule(
                        "named",
                        "body",
                        Optional.empty(),
                        Scope.ofItem(PROTOTYPE, "body").compile("item.name"),
                        "");
        Rules rules = new Rules(world, List.of(crowded, named), 1000, 1000);
        rules.update(1);
        assertThat(all(items, "named")).containsOnly("none");
        rules.update(2);
        assertThat(all(items, "named")).contains("none").hasSizeGreaterThan(1);
        assertThat(of(items.getFirst(), "named")).isEqualTo("b0");
    }

    @Test
    void anEvaluationWithoutAValueCostsAHundredSteps() throws Exception {
        List<Item> items = bodies(50);
        items.forEach(item -> item.semantic().set("width", "unknown"));
        Rules rules = sharing(1000, "wide", "semantic.width > 3.0", "named", "item.name");
        int frames = 0;
        while (of(items.getFirst(), "named").equals("none")) {
            rules.update(++frames);
        }
        assertThat(frames).as("ten evaluations in a frame").isBetween(5, 6);
    }

    @Test
    void costliestRuleIsNamedOnceWhenTheRulesOfAFrameTakeTooManySteps() throws Exception {
        bodies(10);
        Rules rules =
                sharing(1000, "cheap", "physics.temperature >= 0.0", "dear", DEAR, "last", "'x'");

        rules.update(1);
        rules.update(2);

        assertThat(world.events())
                .singleElement()
                .satisfies(
                        event -> {
                            assertThat(event.type()).isEqualTo("fault");
                            assertThat(event.fields())
                                    .containsEntry("source", "rule dear")
                                    .containsEntry("error", "TooManySteps");
                            assertThat(event.fields().get("message").toString())
                                    .contains(
                                            "rule dear took ",
                                            "in frame 1",
                                            "at most 1,000",
                                            "some frames old",
                                            "loop over less",
                                            "`frame: {ruleSteps: 1000}`");
                        });
    }

    @Test
    void itemsThatAreLeftKeepTheirSymbolsUntilTheyAreEvaluated() throws Exception {
        List<Item> items = bodies(10);
        Rules rules =
                sharing(
                        1300,
                        "warm",
                        "physics.temperature > 100.0",
                        "dear",
                        "physics.temperature < 50.0 || " + DEAR,
                        "after",
                        "physics.temperature + 1.0");
        rules.update(1);
        List<Object> before = all(items, "after");

        items.forEach(item -> item.physics().set("temperature", 200));
        rules.update(2);
        assertThat(all(items, "warm")).containsOnly(true);
        assertThat(all(items, "after")).isEqualTo(before).doesNotContain("none");
        for (int frame = 3; frame < 10; frame++) {
            rules.update(frame);
        }
        assertThat(all(items, "after")).containsOnly(201.0);
    }

    /** In a large world, all symbols are complete after the first frame. */
    @Test
    void firstFrameAndTheFirstAfterARestorationMayTakeMoreSteps() throws Exception {
        List<Item> items = bodies(10);
        Scope scope = Scope.ofItem(PROTOTYPE, "body");
        var rule =
                new Rule(
                        "dear",
                        "body",
                        Optional.empty(),
                        scope.compile("physics.temperature < 0.0 || " + DEAR),
                        "");
        Rules rules = new Rules(world, List.of(rule), 1000, 100_000);
        rules.update(1);
        assertThat(all(items, "dear")).containsOnly(true);
        items.forEach(item -> item.semantic().derive("dear", null));

        rules.update(2);
        assertThat(all(items, "dear")).containsOnly("none");
        rules.forget();
        rules.update(3);

        assertThat(all(items, "dear")).containsOnly(true);
        assertThat(world.events()).isEmpty();
    }

    @Test
    void stepsAreChargedToTheAgentThatChangedTheItem() throws Exception {
        List<Item> items = bodies(3);
        Rules rules = sharing(1_000_000, "dear", "physics.temperature < -5.0 || " + DEAR);
        rules.update(1);
        assertThat(world.charges().take()).isEmpty();

        items.get(0).physics().set("temperature", 1); // by no agent
        world.charges().begin("ann");
        items.get(1).physics().set("temperature", 2);
        world.charges().end();
        world.charges().begin("bob");
        items.get(2).physics().set("temperature", -7);
        world.charges().end();
        rules.update(2);

        Map<String, Long> steps = world.charges().take();
        assertThat(steps).containsOnlyKeys("ann", "bob");
        assertThat(steps.get("ann")).isBetween(200L, 500L);
        assertThat(steps.get("bob")).isBetween(2L, 20L);
        items.get(1).physics().set("temperature", 3);
        rules.update(3);
        assertThat(world.charges().take()).isEmpty();
    }

    /** The result is the same for any number of frames until the rule of the item is evaluated. */
    @Test
    void stepsAreChargedAlsoIfTheEvaluationHasToWait() throws Exception {
        List<Item> items = bodies(20);
        Rules rules = sharing(1000, "dear", "physics.temperature < -5.0 || " + DEAR);
        rules.update(1);
        long charged = 0;
        world.charges().begin("ann");
        items.forEach(item -> item.physics().set("temperature", 50));
        world.charges().end();
        for (int frame = 2; frame < 30; frame++) {
            rules.update(frame);
            charged += world.charges().take().getOrDefault("ann", 0L);
        }

        // A result that was computed before the change is computed again.
        assertThat(charged).isBetween(20 * 200L, 20 * 500L);
    }

    @Test
    void createdItemsAreChargedToTheirMakerAndRemovedOnesToNobody() throws Exception {
        Rules rules = sharing(1_000_000, "dear", DEAR);
        world.charges().begin("ann");
        Item kept = body("kept", 1);
        Item gone = body("gone", 1);
        world.charges().end();
        world.remove(gone.id());
        rules.update(1);

        assertThat(world.charges().take().get("ann")).isBetween(200L, 500L);
        assertThat(of(kept, "dear")).isEqualTo(true);
    }

    @Test
    void bodiesThatAreComparedForARelationCountAsSteps() throws Exception {
        List<Item> items =
                IntStream.range(0, 100)
                        .mapToObj(
                                i ->
                                        world.add(
                                                ItemDefinition.named("s" + i)
                                                        .shape(Shape.sphere(1))
                                                        .build()))
                        .toList();
        new BoundingBoxes().update(world);

        sharing(100 * 150, "first", "semantic.near[0]").update(1);
        assertThat(all(items, "first")).doesNotContain("none");
        items.forEach(item -> item.semantic().derive("first", null));
        sharing(100 * 130, "first", "semantic.near[0]").update(2);
        assertThat(all(items, "first")).contains("none");
    }

    @Test
    void evaluationEndsEarlyOnceTheWorldIsStopped() throws Exception {
        List<Item> items = bodies(10);
        FrameBus bus = new FrameBus();
        AtomicInteger asked = new AtomicInteger();
        rules("warm", "physics.temperature >= 0.0")
                .subscribeTo(bus, () -> asked.incrementAndGet() > 4);

        new FrameLoop(world, bus, Timing.DEFAULT, Pacing.FAST).run(0);

        assertThat(Collections.frequency(all(items, "warm"), "none")).isEqualTo(6);
    }

    /** The kept results must always equal those of a world that keeps no results. */
    @Test
    void keptSymbolsAreThoseOfAWorldWithoutMemory() throws Exception {
        long seed = Seed.of("rules");
        var random = new Random(seed);
        String[] texts = {
            "hot",
            "physics.temperature > 5",
            "label",
            "has(semantic.tag) ? semantic.tag + item.name : 'plain'",
            "both",
            "semantic.hot && semantic.label != 'plain'"
        };
        Rules kept = rules(texts);
        Map<Long, Item> items = new HashMap<>();
        for (int round = 0; round < 300; round++) {
            change(random, items, round);
            kept.update(round);
            Map<Long, Map<String, Object>> is = symbols(items);
            rules(texts).update(round);
            assertThat(is).as("seed %d, round %d", seed, round).isEqualTo(symbols(items));
        }
    }

    private void change(Random random, Map<Long, Item> items, int round) {
        Item[] all = items.values().toArray(new Item[0]);
        Item any = all.length == 0 ? null : all[random.nextInt(all.length)];
        switch (any == null ? 0 : random.nextInt(6)) {
            case 0 -> {
                Item added =
                        random.nextBoolean()
                                ? body("i" + round, random.nextInt(10))
                                : world.add(ItemDefinition.named("i" + round).build());
                items.put(added.id().value(), added);
            }
            case 1 -> {
                items.remove(any.id().value());
                world.remove(any.id());
            }
            case 2 -> any.physics().set("temperature", random.nextInt(10));
            case 3 -> any.semantic().set("tag", "t" + random.nextInt(3));
            case 4 -> any.semantic().remove("tag");
            default -> world.rename(any.id(), "r" + round);
        }
    }

    private static Map<Long, Map<String, Object>> symbols(Map<Long, Item> items) {
        Map<Long, Map<String, Object>> all = new HashMap<>();
        items.forEach((id, item) -> all.put(id, item.semantic().symbols()));
        return all;
    }
}
