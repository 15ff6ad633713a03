// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.World;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.stream.Collectors;
import java.util.stream.IntStream;

/** Repeated items. */
class RepeatTest {
    private static final String START = "reve: 1\nname: w\n";

    private static List<ItemDefinition> items(String yaml) throws WorldFileException {
        return WorldFileTest.parse(START + "items:\n" + yaml).items();
    }

    private static List<String> problems(String yaml) {
        WorldFileException refused =
                catchThrowableOfType(WorldFileException.class, () -> items(yaml));
        assertThat(refused).as("refusal of\n%s", yaml).isNotNull();
        return refused.problems().stream().map(Problem::toString).toList();
    }

    @Test
    void aCountMakesItemsWithTheIndexI() throws WorldFileException {
        List<ItemDefinition> items =
                items(
                        """
                          - name: ball-{i}
                            repeat: 3
                            physical: {location: "{[0.5 * i, 0, 0]}"}
                            semantic: {number: "{i}", title: "ball {i + 1} of 3"}
                            physics: {mass: "{i + 1} g", velocity: ["{-i}", 0, 1]}
                        """);

        assertThat(items)
                .extracting(ItemDefinition::name)
                .containsExactly("ball-0", "ball-1", "ball-2");
        ItemDefinition last = items.getLast();
        assertThat(last.location()).containsExactly(1, 0, 0);
        assertThat(last.symbols())
                .containsEntry("number", 2.0)
                .containsEntry("title", "ball 3 of 3");
        assertThat(last.physics("mass").orElseThrow()).containsExactly(0.003);
        assertThat(last.physics("velocity").orElseThrow()).containsExactly(-2, 0, 1);
    }

    @Test
    void aClothIsBodiesAndSpringsBetweenThem() throws WorldFileException {
        WorldDescription cloth =
                WorldFileTest.parse(
                        START
                                + """
                                prefabs:
                                  thread: {kind: spring, physics: {springConstant: 50, length: 0.1}}
                                items:
                                  - name: knot-{i}-{j}
                                    repeat: {i: 4, j: 5}
                                    physical: {location: "{0.1 * [i, 0, j]}"}
                                    physics: {mass: 0.01}
                                  - name: weft-{i}-{j}
                                    like: thread
                                    repeat: {i: 4, j: 4}
                                    physics: {end1: "knot-{i}-{j}", end2: "knot-{i}-{j+1}"}
                                  - name: warp-{i}-{j}
                                    like: thread
                                    repeat: {i: 3, j: 5}
                                    physics: {end1: "knot-{i}-{j}", end2: "knot-{i+1}-{j}"}
                                """);
        try (var arena = new OffHeapArena()) {
            World world = cloth.build(arena);
            assertThat(world.table("body").rowCount()).isEqualTo(20);
            assertThat(world.table("spring").rowCount()).isEqualTo(31);
            assertThat(cloth.items())
                    .extracting(ItemDefinition::name)
                    .startsWith("knot-0-0", "knot-0-1")
                    .contains("weft-3-3", "warp-2-4");
            assertThat(world.find("knot-2-3").orElseThrow().physical().location())
                    .containsExactly(0.2, 0, 0.1 * 3);
        }
    }

    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '|',
            textBlock =
                    """
                    1 + 2 * 3 - 4 / 8 | 6.5
                    -2 ^ 2            | -4
                    2 ^ -1            | 0.5
                    2 ^ 3 ^ 2         | 512
                    -7 % 3            | 2
                    (1 + 2) * .5e1    | 15
                    2 - -3            | 5
                    k * 10 + j        | 21
                    sin(pi / 6) * 2   | 1
                    atan2(1, 1) * 4 - pi | 0
                    max(k, j) + min(k, j) | 3
                    floor(-0.5) + abs(-3) + sqrt(16) + cbrt(27) | 9
                    log(exp(2)) + tan(0) + asin(0) + acos(1) + atan(0) + cos(0) | 3
                    """)
    void formulasAreArithmetic(String formula, double expected) {
        double[] value = Formula.parse(formula, List.of("k", "j")).value(new double[] {2, 1}, 0);
        assertThat(value).containsExactly(new double[] {expected}, within(1e-15));
    }

    @Test
    void formulasWorkOnListsElementByElement() {
        assertThat(Formula.parse("[1, 2, 3] * [2, 2, 2] - 1", List.of()).value(new double[0], 0))
                .containsExactly(1, 3, 5);
        assertThat(Formula.parse("-abs([1, -2])", List.of()).value(new double[0], 0))
                .containsExactly(-1, -2);
    }

    @Test
    void randomNumbersFollowFromSeedAndRepetition() throws WorldFileException {
        String yaml =
                """
                  - name: a{i}
                    repeat: 1000
                    physical: {location: "{10 * ball(3)}"}
                    physics: {mass: "{random(1)}", velocity: "{sphere(2)}", torque: "{box(4)}"}
                """;
        List<ItemDefinition> items = items(yaml);

        assertThat(items.get(5).location()).isEqualTo(items(yaml).get(5).location());
        assertThat(items.stream().map(item -> item.location()[0]).distinct()).hasSize(1000);
        assertThat(items)
                .allMatch(item -> length(item.location()) <= 10)
                .allMatch(
                        item ->
                                Math.abs(length(item.physics("velocity").orElseThrow()) - 1)
                                        < 1e-15);
        assertThat(mean(items, "mass", 0)).isCloseTo(0.5, within(0.05));
        for (int axis = 0; axis < 3; axis++) {
            assertThat(mean(items, "velocity", axis)).isCloseTo(0, within(0.1));
            assertThat(mean(items, "torque", axis)).isCloseTo(0, within(0.1));
        }
        assertThat(items.stream().filter(item -> length(item.location()) < 5).count())
                .as("an eighth of the ball")
                .isBetween(80L, 170L);
        assertThat(new RandomNumbers(1, 0).next())
                .as("the same on every machine and for ever")
                .isEqualTo(FIRST_OF_SEED_ONE);
    }

    private static final double FIRST_OF_SEED_ONE = 0.2558852031320078;

    private static double length(double[] v) {
        return Math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    }

    private static double mean(List<ItemDefinition> items, String property, int component) {
        return items.stream()
                .mapToDouble(item -> item.physics(property).orElseThrow()[component])
                .average()
                .orElseThrow();
    }

    @Test
    void bracesOfItemsThatAreNotRepeatedAreText() throws WorldFileException {
        assertThat(items("  - {name: 'a{i}', semantic: {x: '{'}}\n").getFirst().symbols())
                .containsEntry("x", "{");
        assertThat(items("  - {name: 'a{{{i}}}', repeat: 1}\n").getFirst().name())
                .isEqualTo("a{0}");
    }

    @Test
    void repeatingZeroTimesMakesNothing() throws WorldFileException {
        assertThat(items("  - {name: 'a{i}', repeat: 0}\n  - {name: 'b{i}', repeat: {i: 5, j: 0}}"))
                .isEmpty();
    }

    @Test
    void childrenMayBeRepeatedBesideTheirParents() throws WorldFileException {
        List<ItemDefinition> items =
                items(
                        """
                          - {name: "cart-{c}", repeat: {c: 2}, physics: {mass: 1}}
                          - name: wheel-{c}-{w}
                            repeat: {c: 2, w: 4}
                            parent: cart-{c}
                            physical: {location: "{[2 * floor(w / 2) - 1, 0, 2 * (w % 2) - 1]}"}
                        """);
        assertThat(items.getLast().parent()).contains("cart-1");
        assertThat(items.getLast().location()).containsExactly(1, 0, 1);
    }

    @Test
    void wrongFormulasAreToldOnceWithWhatIsWrong() {
        assertThat(
                        problems(
                                """
                                  - name: a{i}
                                    repeat: 100
                                    physical: {location: "{[1 / i, 0, 0]}", orientation: "{[1, 2] + [1, 2, 3]}"}
                                    semantic: {a: "{k}", b: "{i +}", c: "{foo(1)}", d: "{sin(1, 2)}", e: "{i", f: "}",
                                      g: "{}", h: "{(i}", k: "{[i, [i]]}", l: "{i i}", m: "{[i, [i, i]]}"}
                                """))
                .containsExactly(
                        "world.yaml:6:26: location: a formula in `{[1 / i, 0, 0]}` is not a finite"
                                + " number where i = 0",
                        "world.yaml:6:58: orientation: a formula in `{[1, 2] + [1, 2, 3]}` combines"
                                + " 2 numbers with 3 where i = 0",
                        "world.yaml:7:19: a: formula `k` names `k`, which is unknown; known are i",
                        "world.yaml:7:29: b: formula `i +` has its end where a number, a name or a"
                                + " bracket is expected",
                        "world.yaml:7:41: c: formula `foo(1)` calls `foo`, which is no function",
                        "world.yaml:7:56: d: formula `sin(1, 2)` gives sin 2 arguments, expected 1",
                        "world.yaml:7:74: e: `{` stands alone; a formula is `{…}`, a plain brace is"
                                + " written twice",
                        "world.yaml:7:83: f: `}` stands alone; a formula is `{…}`, a plain brace is"
                                + " written twice",
                        "world.yaml:8:10: g: formula `` has its end where a number, a name or a"
                                + " bracket is expected",
                        "world.yaml:8:19: h: formula `(i` has its end where `)` is expected",
                        "world.yaml:8:47: l: formula `i i` has `i` where the end is expected",
                        "world.yaml:8:59: m: a formula in `{[i, [i, i]]}` has a list where a list"
                                + " takes one number where i = 0");
    }

    @Test
    void wrongRepetitionsAreRefused() {
        assertThat(problems("  - {name: a, repeat: 3}\n"))
                .containsExactly(
                        "world.yaml:4:12: name: the item is repeated, so its name needs a formula,"
                                + " as in `ball-{i}`");
        assertThat(problems("  - {name: a, repeat: -1}\n"))
                .containsExactly("world.yaml:4:23: repeat: found number -1, expected at least 0");
        assertThat(problems("  - {name: 'a{i}', repeat: {i: 1.5}}\n"))
                .containsExactly("world.yaml:4:32: i: found number 1.5, expected a whole number");
        assertThat(problems("  - {name: 'a{sin}', repeat: {sin: 2}}\n"))
                .containsExactly(
                        "world.yaml:4:31: `sin` means something else in formulas; choose another"
                                + " name");
        assertThat(problems("  - {name: 'a{i}', repeat: {a-b: 1, i: 2}}\n"))
                .containsExactly(
                        "world.yaml:4:29: `a-b` is not a name; "
                                + "expected a letter, then letters, digits or "
                                + "_, at most 47 in all");
        assertThat(problems("  - {name: 'a{i % 2}', repeat: 3}\n"))
                .containsExactly("world.yaml:4:12: duplicate item name `a0`, first on line 4");
        assertThat(problems("  - {name: 'a{i}', repeat: {i: 1000000, j: 1000000, k: 1000000}}\n"))
                .containsExactly("world.yaml:4:5: more than 1000000 items with their repetitions");
        assertThat(
                        problems(
                                "  - {name: 'a{i}', repeat: 900000, semantic: {"
                                        + IntStream.range(0, 12)
                                                .mapToObj(n -> "s" + n + ": '{i}'")
                                                .collect(Collectors.joining(", "))
                                        + "}}\n"))
                .containsExactly(
                        "world.yaml:4:5: more than 10000000 values in all items with what "
                                + "they are like and their repetitions");
    }

    @Test
    void parentsAreBodiesAndNeverTheirOwn() {
        assertThat(
                        problems(
                                """
                                  - {name: a, parent: b}
                                  - {name: b, parent: a}
                                  - {name: c, parent: d}
                                  - {name: e, parent: a, physics: {mass: 1 g}}
                                  - {name: f, parent: a, physics: {mass: 0 g}}
                                  - {name: s, kind: spring, parent: a, physics: {end1: f, end2: e}}
                                  - {name: g, parent: s}
                                """))
                .containsExactly(
                        "world.yaml:4:23: parent: `a` would be its own parent, by way of a, b",
                        "world.yaml:6:23: parent: no item is named `d`",
                        "world.yaml:7:42: mass: an item with a `parent` moves with it and not by"
                                + " laws; expected mass 0, or none",
                        "world.yaml:9:29: only items of kind body have a `parent`, this is a"
                                + " spring",
                        "world.yaml:10:23: parent: `s` is a spring, expected a body");
    }

    @TempDir private Path folder = Path.of("");

    private WorldDescription load(String csv, String items) throws Exception {
        Files.createDirectories(folder.resolve("data"));
        Files.writeString(folder.resolve("data/suns.csv"), csv);
        Path world = folder.resolve("world.yaml");
        return WorldFile.load(Files.writeString(world, START + "items:\n" + items));
    }

    @Test
    void aCsvFileMakesAnItemOfEachLine() throws Exception {
        List<ItemDefinition> suns =
                load(
                                """
                                # made by hand
                                mass, position.x,position.y
                                1,2,3.5

                                1e3 , -4 ,0
                                """,
                                """
                                  - name: sun {i}
                                    repeat: data/suns.csv
                                    physical: {location: "{[position.x, position.y, 0]}"}
                                    physics: {mass: "{mass} g"}
                                """)
                        .items();

        assertThat(suns).extracting(ItemDefinition::name).containsExactly("sun 0", "sun 1");
        assertThat(suns.getLast().location()).containsExactly(-4, 0, 0);
        assertThat(suns.getLast().physics("mass").orElseThrow()).containsExactly(1);
    }

    @ParameterizedTest(name = "{1}")
    @CsvSource(
            delimiter = '|',
            textBlock =
                    """
                    a,b;1,2,3      | 2:3: found 3 numbers, expected 2, one for each name in the first line
                    a,b;1          | 2:1: found 1 numbers, expected 2, one for each name in the first line
                    a,b;1,x        | 2:3: b: found `x`, expected a finite number
                    a,b;1,NaN      | 2:3: b: found `NaN`, expected a finite number
                    a,sin;1,2      | 1:3: `sin` cannot be the name of a column: expected a letter, then letters, digits, _ or ., neither given twice nor a function or constant of formulas
                    # empty        | 1:1: the file is empty; its first line names the columns
                    """)
    void wrongCsvFilesAreRefusedWhereTheyAreWrong(String csv, String message) {
        WorldFileException refused =
                catchThrowableOfType(
                        WorldFileException.class,
                        () ->
                                load(
                                        csv.replace(';', '\n'),
                                        "  - {name: 'a{i}', repeat: data/suns.csv}\n"));

        assertThat(refused).hasMessage(folder + "/data/suns.csv:" + message);
    }

    @Test
    void aCsvFileOutsideTheFolderIsNotRead() throws IOException {
        WorldFileException refused =
                catchThrowableOfType(
                        WorldFileException.class,
                        () -> load("a\n1\n", "  - {name: 'a{i}', repeat: ../suns.csv}\n"));

        assertThat(refused)
                .hasMessage(
                        folder
                                + "/world.yaml:4:28: repeat: ../suns.csv: expected a path within"
                                + " the world's folder, such as models/duck.glb: not an absolute"
                                + " one, without `..`, `.`, `:` or `\\`");
    }
}
