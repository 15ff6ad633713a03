// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.image.WorldDigest;
import reve.core.rule.Rule;
import reve.core.world.ActionRefused;
import reve.core.world.Colour;
import reve.core.world.ConnectionLook;
import reve.core.world.Item;
import reve.core.world.ItemId;
import reve.core.world.OffHeapArena;
import reve.core.world.Shape;
import reve.core.world.World;

import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/**
 * Edits of a running world. The tests check the effect of each edit, and that a refused edit
 * changes nothing.
 */
class WorldEditTest {
    private static final String WORLD =
            """
            reve: 1
            name: w
            items:
              - {name: a, physical: {shape: sphere, radius: 1}, physics: {mass: 1}}
              - {name: b, physical: {location: [2, 0, 0]}, physics: {mass: 2}}
              - {name: c, physical: {location: [4, 0, 0]}, physics: {mass: 0}}
              - {name: s, kind: spring, physics: {end1: a, end2: b, length: 1}}
              - {name: sign, physical: {shape: box, size: [1, 1, 1]}, semantic: {text: hello}}
            """;

    private OffHeapArena arena;
    private World world;
    private EditReader reader;
    private EditReader.Room room;

    @BeforeEach
    void build() throws WorldFileException {
        arena = new OffHeapArena();
        world = WorldFile.parse("w", WORLD.getBytes(StandardCharsets.UTF_8)).build(arena);
        reader = new EditReader(world.prototype());
        room = new EditReader.Room();
    }

    @AfterEach
    void close() {
        arena.close();
    }

    private void make(WorldEdit... edits) throws ActionRefused {
        WorldEdit.make(world, 1, List.of(edits), Set.of(), () -> {});
    }

    private Item item(String name) {
        return world.find(name).orElseThrow();
    }

    private WorldEdit change(String item, String to) throws WorldFileException {
        return reader.change(item, item(item).kind(), to);
    }

    /** Returns the complete state of the world. */
    private List<Object> state() {
        List<Object> state = new ArrayList<>();
        for (Item each : world.items()) {
            state.add(each.id());
            state.add(each.name());
            state.add(each.semantic().symbols());
            state.add(each.physics().properties());
            if (!each.physical().isEmpty()) {
                state.add(each.physical().shape());
                state.add(each.physical().location()[0]);
            }
        }
        var digest = new WorldDigest(world);
        long[] parts = new long[digest.size()];
        digest.compute(parts);
        state.addAll(Arrays.stream(parts).boxed().toList());
        return state;
    }

    /** The world waits while the conditions are compiled. */
    @Test
    void oneMessageHasAFewHundredConditions() throws Exception {
        String name = world.items().getFirst().name();
        var room = new EditReader.Room();
        reader.change(name, item(name).kind(), withConditions("a", 0, 200), room);
        reader.change(name, item(name).kind(), withConditions("a", 200, 250), room);
        assertThatThrownBy(
                        () ->
                                reader.change(
                                        name,
                                        item(name).kind(),
                                        withConditions("b", 250, 251),
                                        room))
                .hasMessageContaining("the actions have more than 250 different expressions");
        change(name, withConditions("c", 0, 250));
        assertThatThrownBy(() -> change(name, withConditions("d", 0, 251)))
                .hasMessageContaining("more than 250 different expressions");
    }

    private static String withConditions(String action, int from, int to) {
        StringBuilder actions = new StringBuilder();
        for (int i = from; i < to; i++) {
            actions.append(actions.isEmpty() ? "" : ", ")
                    .append(action + i + ": {when: 1 < " + (i + 2) + ", effects: [{raise: e}]}");
        }
        return "access: {" + actions + "}";
    }

    /** Such an item would be stored, and no later start could read the store. */
    @Test
    void anItemWithAVoiceGetsNoActionOfTheNameOfItsSpeech() throws Exception {
        make(
                reader.add(
                        "items: [{name: lent, physical: {shape: sphere, radius: 1}, voice: {}}]",
                        room));
        List<Object> before = state();
        assertThatThrownBy(() -> make(change("lent", "access: {say: {effects: [{raise: x}]}}")))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining("item lent has a voice, so none of its actions");
        assertThat(state()).isEqualTo(before);
        make(change("lent", "access: {shout: {effects: [{raise: x}]}}"));
        assertThat(item("lent").access().find("shout")).isPresent();
    }

    /** An agent may remove its own body. Then the world still keeps the body for the agent. */
    @Test
    void aBodyThatIsGoneHindersNoEdit() throws Exception {
        ItemId gone = world.find("c").orElseThrow().id();
        ItemId body = world.find("a").orElseThrow().id();
        world.remove(gone);
        List<WorldEdit> edits =
                List.of(new WorldEdit.Remove("sign", false), new WorldEdit.Remove("s", false));
        WorldEdit.make(world, 1, edits, List.of(gone, body), () -> {});
        assertThat(world.find("sign")).isEmpty();
        assertThatThrownBy(
                        () ->
                                WorldEdit.make(
                                        world,
                                        1,
                                        List.of(
                                                new WorldEdit.Remove("b", false),
                                                new WorldEdit.Remove("a", false)),
                                        List.of(gone, body),
                                        () -> {}))
                .hasMessageContaining("a is the body of an agent");
    }

    @Test
    void itemsAreAddedWithUnitsPrefabsAndRepetitions() throws Exception {
        make(
                reader.add(
                        """
                        {"prefabs": {"ball": {"physical": {"shape": "sphere", "radius": "5 cm"}}},
                         "items": [{"name": "ball {i}", "repeat": 3, "like": "ball",
                                    "physical": {"location": ["{i}", 0, 0]},
                                    "physics": {"mass": "300 g"}},
                                   {"name": "rope", "kind": "spring",
                                    "physics": {"end1": "ball 0", "end2": "a", "length": "1 m"}}]}
                        """,
                        room));
        assertThat(item("ball 2").physics().scalar("mass")).isEqualTo(0.3);
        assertThat(item("ball 2").physical().location()).containsExactly(2, 0, 0);
        assertThat(item("ball 1").physical().shape()).isEqualTo(Shape.sphere(0.05));
        assertThat(item("rope").physics().reference("end2")).isEqualTo(item("a").id());
    }

    @Test
    void anItemIsRenamedReshapedAndMoved() throws Exception {
        make(
                change(
                        "a",
                        """
                        {"name": "ball", "physical": {"shape": "box", "size": [1, 2, 3],
                         "location": [0, 5, 0], "colour": "#ff0000"}, "physics": {"mass": "2 kg"}}
                        """));
        assertThat(world.find("a")).isEmpty();
        Item ball = item("ball");
        assertThat(ball.physical().shape()).isEqualTo(Shape.box(1, 2, 3));
        assertThat(ball.physical().location()).containsExactly(0, 5, 0);
        assertThat(ball.physical().colour().toString()).startsWith("#ff0000");
        assertThat(ball.physics().scalar("mass")).isEqualTo(2);
    }

    @Test
    void aShapeWithDensityGivesMassAndInertia() throws Exception {
        make(
                change(
                        "a",
                        "{\"physical\": {\"shape\": \"box\", \"size\": [1, 1, 1]},"
                                + " \"physics\": {\"density\": 500}}"));
        assertThat(item("a").physics().scalar("mass")).isEqualTo(500);
        assertThat(item("a").physics().vector("inertia")[0]).isEqualTo(500.0 / 6);
    }

    @Test
    void endsOfASpringChange() throws Exception {
        make(change("s", "{\"physics\": {\"end2\": \"c\"}}"));
        assertThat(item("s").physics().reference("end2")).isEqualTo(item("c").id());
        List<Object> before = state();
        assertThatThrownBy(() -> make(change("s", "{\"physics\": {\"end1\": \"c\"}}")))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining("item s: physics.end2 refers to c twice");
        assertThat(state()).isEqualTo(before);
    }

    @Test
    void anItemGetsAndLosesItsParent() throws Exception {
        make(change("sign", "{\"parent\": \"a\"}"));
        assertThat(item("sign").definition().parent()).contains("a");
        make(change("sign", "{\"parent\": null}"));
        assertThat(item("sign").definition().parent()).isEmpty();
    }

    @Test
    void symbolsAndActionsComeAndGo() throws Exception {
        make(
                change(
                        "sign",
                        """
                        {"semantic": {"text": null, "worn": true},
                         "access": {"wipe": {"effects": [{"symbol": "worn", "to": false}]}}}
                        """));
        assertThat(item("sign").semantic().get("text")).isEmpty();
        assertThat(item("sign").semantic().get("worn")).contains(true);
        assertThat(item("sign").access().find("wipe")).isPresent();
        make(change("sign", "{\"access\": {\"wipe\": null}}"));
        assertThat(item("sign").access().find("wipe")).isEmpty();
    }

    @Test
    void sceneryBecomesABodyAndSceneryAgain() throws Exception {
        make(change("sign", "{\"physics\": {\"mass\": 3, \"velocity\": [1, 0, 0]}}"));
        assertThat(item("sign").physics().vector("velocity")).containsExactly(1, 0, 0);
        make(change("sign", "{\"physics\": null}"));
        assertThat(item("sign").physics().isEmpty()).isTrue();
    }

    @Test
    void constantsOfTheWorldChange() throws Exception {
        make(change("world", "{\"physics\": {\"gravity\": \"0 -1 0 m/s^2\"}}"));
        assertThat(item("world").physics().vector("gravity")).containsExactly(0, -1, 0);
    }

    @Test
    void itemsAreRemovedAloneOrWithWhatRefersToThem() throws Exception {
        make(new WorldEdit.Remove("sign", false));
        assertThat(world.find("sign")).isEmpty();
        assertThatThrownBy(() -> make(new WorldEdit.Remove("a", false)))
                .hasMessageContaining("refers to it or is attached to it");
        make(new WorldEdit.Remove("a", true));
        assertThat(world.find("a")).isEmpty();
        assertThat(world.find("s")).isEmpty();
    }

    @Test
    void aBatchHappensInItsOrder() throws Exception {
        make(
                new WorldEdit.Remove("s", false),
                reader.add("{\"items\": [{\"name\": \"s\", \"physics\": {\"mass\": 7}}]}", room),
                reader.change("s", "body", "{\"name\": \"weight\"}"));
        assertThat(item("weight").physics().scalar("mass")).isEqualTo(7);
    }

    @Test
    void aBatchWithARefusedEditChangesNothing() throws Exception {
        List<Object> before = state();
        WorldEdit[] edits = {
            new WorldEdit.Remove("s", false),
            change("a", "{\"physics\": {\"mass\": 9}}"),
            reader.add("{\"items\": [{\"name\": \"d\", \"physics\": {\"mass\": 7}}]}", room),
            new WorldEdit.Remove("nothing", false)
        };
        ActionRefused refused = catchThrowableOfType(ActionRefused.class, () -> make(edits));
        assertThat(refused.code()).isEqualTo("no-such-item");
        assertThat(refused).hasMessage("edit 4 of 4: the world has no item \"nothing\"");
        assertThat(state()).isEqualTo(before);
    }

    @Test
    void aChangeOfWhichOnePartIsRefusedChangesNothing() throws Exception {
        List<Object> before = state();
        WorldEdit edit = change("a", "{\"semantic\": {\"x\": 1}, \"name\": \"b\"}");
        assertThatThrownBy(() -> make(edit)).hasMessageContaining("b");
        assertThat(state()).isEqualTo(before);
    }

    @Test
    void aRefusalBetweenTrialAndChangeChangesNothing() throws Exception {
        List<Object> before = state();
        List<WorldEdit> edits = List.of(change("a", "{\"physics\": {\"mass\": 9}}"));
        assertThatThrownBy(
                        () ->
                                WorldEdit.make(
                                        world,
                                        1,
                                        edits,
                                        Set.of(),
                                        () -> {
                                            throw new ActionRefused("edit-refused", "no");
                                        }))
                .hasMessage("no");
        assertThat(state()).isEqualTo(before);
    }

    @Test
    void whatIsKeptStays() {
        Set<ItemId> kept = Set.of(item("s").id());
        for (WorldEdit edit :
                List.of(new WorldEdit.Remove("s", false), new WorldEdit.Remove("a", true))) {
            assertThatThrownBy(() -> WorldEdit.make(world, 1, List.of(edit), kept, () -> {}))
                    .hasMessageContaining("s is the body of an agent");
            assertThat(world.find("s")).isPresent();
        }
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '!',
            textBlock =
                    """
                    {"physics": {"mass": "3 m"}}        ! unit m does not fit kg
                    {"physics": {"mas": 3}}             ! unknown physics property `mas` of kind body; did you mean `mass`?
                    {"physics": {"mass": -3}}           ! mass: found -3.0, expected
                    {"physics": {"mass": null}}         ! cannot be removed; null removes a parent
                    {"kind": "spring"}                  ! `kind` of an item cannot be changed
                    {"physical": {"radius": 2}}         ! `radius` without a `shape`
                    {"physical": {"shape": "mesh", "file": "/etc/passwd"}} ! file
                    {"semantic": {"name": "x"}}         ! name
                    {}                                  ! found nothing to change
                    {"physics": {"density": 3}}         ! shape
                    """)
    void aChangeThatDoesNotFitIsRefusedWithItsReason(String to, String reason) {
        WorldFileException refused =
                catchThrowableOfType(WorldFileException.class, () -> change("b", to));
        assertThat(refused).as(to).isNotNull();
        assertThat(refused.problems().getFirst().message()).contains(reason.strip());
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '!',
            textBlock =
                    """
                    {"items": [{"name": "a"}]}                             ! a
                    {"items": [{"name": "x", "parent": "nothing"}]}        ! nothing
                    {"items": [{"name": "x", "kind": "spring", "physics": {"end1": "a", "end2": "sign"}}]} ! sign
                    """)
    void itemsThatDoNotFitTheWorldAreRefused(String items, String reason) throws Exception {
        List<Object> before = state();
        WorldEdit edit = reader.add(items, room);
        assertThatThrownBy(() -> make(edit))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining(reason.strip());
        assertThat(state()).isEqualTo(before);
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '!',
            textBlock =
                    """
                    {"items": [{"name": "x{i}", "repeat": 10001}]}  ! more than 10000 items with their repetitions in one message
                    {"items": [], "laws": ["drag"]}              ! `laws` cannot be added
                    {"items": [{"nam": "x"}]}                    ! nam
                    {"items": [{"name": "x", "like": "ball"}]}   ! ball
                    """)
    void itemsThatAreNotValidAreRefused(String items, String reason) {
        WorldFileException refused =
                catchThrowableOfType(WorldFileException.class, () -> reader.add(items, room));
        assertThat(refused).as(items).isNotNull();
        assertThat(refused.problems().toString()).contains(reason.strip());
    }

    @Test
    void aWorldHasAMillionItemsAtMost() throws Exception {
        WorldEdit.requireRoom(990_000, 10_000);
        assertThatThrownBy(() -> WorldEdit.requireRoom(990_001, 10_000))
                .isInstanceOf(ActionRefused.class)
                .hasMessage(
                        "the world has 990001 items; with 10000 more it would exceed the limit of"
                                + " 1000000");
    }

    /** The limits of a message hold for all its changes together. */
    @Test
    void changesOfOneMessageAddATenThousandItemsAtMost() throws Exception {
        reader.add("{\"items\": [{\"name\": \"x{i}\", \"repeat\": 6000}]}", room);
        WorldFileException refused =
                catchThrowableOfType(
                        WorldFileException.class,
                        () ->
                                reader.add(
                                        "{\"items\": [{\"name\": \"y{i}\", \"repeat\": 6000}]}",
                                        room));
        assertThat(refused.problems().getFirst().message())
                .isEqualTo("more than 10000 items with their repetitions in one message");
        reader.add("{\"items\": [{\"name\": \"y{i}\", \"repeat\": 4000}]}", room);
    }

    /** Each repetition of an item counts with all its texts, in each change of the message. */
    @Test
    void changesOfOneMessageAddFourMillionCharactersAtMost() throws Exception {
        String text = "z".repeat(900);
        String add =
                "{\"items\": [{\"name\": \"%s{i}\", \"repeat\": 2000, \"semantic\": {\"a\": [\""
                        + text
                        + "\", \""
                        + text
                        + "\"]}}]}";
        reader.add(add.formatted("x"), room);
        WorldFileException refused =
                catchThrowableOfType(
                        WorldFileException.class, () -> reader.add(add.formatted("y"), room));
        assertThat(refused.problems().getFirst().message())
                .isEqualTo(
                        "the symbols of all items with their repetitions have more than 4000000"
                                + " characters in one message; the item y222 exceeds the limit");
        byte[] world =
                ("reve: 1\nname: w\nprefabs: {p: {semantic: {a: ["
                                + text
                                + "]}}}\nitems: [{name: 'x{i}', like: p, repeat: 9000}]\n")
                        .getBytes(StandardCharsets.UTF_8);
        assertThat(WorldFile.parse("w", world).items()).hasSize(9000);
        assertThatThrownBy(() -> WorldFile.parseMessage("w", world))
                .isInstanceOf(WorldFileException.class)
                .hasMessageContaining("more than 4000000 characters in one message");
    }

    private List<Rule> rules(List<Rule> before, String name, String text) throws ActionRefused {
        return reader.rules(before, Map.of(name, Optional.ofNullable(text)));
    }

    @Test
    void rulesAreAddedReplacedAndRemoved() throws Exception {
        List<Rule> one = rules(List.of(), "heavy", "\"physics.mass > 1.0\"");
        List<Rule> two = rules(one, "lazy", "{\"is\": \"semantic.heavy\", \"doc\": \"At rest.\"}");
        assertThat(two).extracting(Rule::symbol).containsExactly("heavy", "lazy");
        List<Rule> changed = rules(two, "heavy", "\"physics.mass > 5.0\"");
        assertThat(changed).extracting(Rule::symbol).containsExactly("heavy", "lazy");
        assertThat(changed.getFirst().source()).isNotEqualTo(two.getFirst().source());
        assertThat(rules(changed, "heavy", null)).extracting(Rule::symbol).containsExactly("lazy");
        assertThatThrownBy(() -> rules(two, "heavy", "\"semantic.lazy\""))
                .isInstanceOf(ActionRefused.class)
                .hasMessage("rule heavy: rule heavy reads what rule lazy gives, which comes later");
        assertThatThrownBy(() -> rules(two, "x", "\"physics.mas > 1\""))
                .isInstanceOf(ActionRefused.class)
                .hasMessageStartingWith("rule x: ");
    }

    /**
     * The order of the rules is checked once for all changes. Therefore a rule may read a rule that
     * follows it.
     */
    @Test
    void rulesOfOneMessageChangeTogetherUpToALimit() throws Exception {
        Map<String, Optional<String>> many = new LinkedHashMap<>();
        for (int i = 0; i < 256; i++) {
            many.put("r" + i, Optional.of("\"physics.mass > " + i + ".0\""));
        }
        List<Rule> full = reader.rules(List.of(), many);
        assertThat(full).hasSize(256);
        assertThatThrownBy(() -> rules(full, "more", "\"physics.mass > 1.0\""))
                .hasMessage("the world would have 257 rules, expected at most 256");
        assertThat(rules(full, "r7", null)).hasSize(255);
        assertThat(rules(full, "r9", "\"semantic.r8\"")).hasSize(256);
    }

    @Test
    void aSpringChangesItsLook() throws Exception {
        make(change("s", "{\"physical\": {\"width\": \"3 cm\"}}"));
        assertThat(item("s").physical().look()).isEqualTo(ConnectionLook.DEFAULT.with(0.03));
        make(change("s", "{\"physical\": {\"colour\": \"#ff0000\"}}"));
        assertThat(item("s").definition().look())
                .isEqualTo(new ConnectionLook(Optional.of(Colour.parse("#ff0000")), 0.03));
        assertThatThrownBy(() -> change("sign", "{\"physical\": {\"width\": 1}}"))
                .hasMessageContaining("only items of kind spring have a `width`, this is a body");
        assertThatThrownBy(() -> item("sign").physical().setWidth(1))
                .isInstanceOf(IllegalArgumentException.class)
                .hasMessageContaining("is a body, expected a spring: only springs have a width");
    }
}
