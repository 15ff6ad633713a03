// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.world.Action;
import reve.core.world.ItemDefinition;

import java.lang.management.ManagementFactory;
import java.nio.charset.StandardCharsets;
import java.util.List;
import java.util.concurrent.Callable;
import java.util.function.IntFunction;
import java.util.stream.Collectors;
import java.util.stream.IntStream;

/**
 * Short files that could occupy a reader for a long time. The reader refuses a file that is too
 * large before it builds anything from it, and it reads content that many items share only once.
 * The tests count work, or compare the processor time of a large file with that of a small one.
 */
@Tag("slow")
class CostlyWorldsTest {
    private static final String START = "reve: 1\nname: w\n";

    private static List<Problem> problems(String text) {
        WorldFileException refused =
                catchThrowableOfType(WorldFileException.class, () -> read(text));
        return refused == null ? List.of() : refused.problems();
    }

    private static List<ItemDefinition> read(String text) throws WorldFileException {
        return WorldFile.parse("w", text.getBytes(StandardCharsets.UTF_8)).items();
    }

    private static String times(int count, IntFunction<String> line) {
        return IntStream.range(0, count).mapToObj(line).collect(Collectors.joining());
    }

    /**
     * Each declaration also has a mistake. A reader that reads the declarations would report it.
     */
    @ParameterizedTest
    @CsvSource(
            delimiter = '!',
            textBlock =
                    """
                    properties: ! - {name: p%d, kind: body, unit: foo} ! a list of 60000
                    symbols:    ! '  s%d: {unit: foo}'                 ! a mapping
                    rules:      ! '  r%d: foo'                         ! a mapping
                    classes:    ! '  c%d: nowhere'                     ! a mapping
                    laws:       ! - {name: l%d, parameters: {a: 1 foo}} ! a list of 60000
                    """)
    void declarationsAreCountedBeforeAnyIsRead(String key, String line, String found) {
        assertThat(problems(START + key + "\n" + times(60_000, i -> line.formatted(i) + "\n")))
                .singleElement()
                .satisfies(
                        problem ->
                                assertThat(problem.message())
                                        .contains("found " + found + ", expected at most"));
    }

    @Test
    void whatFilesDeclareTogetherIsCountedBeforeAnyIsRead() throws Exception {
        var problems = new Problems("w");
        Node list =
                YamlReader.read(
                        "properties:\n"
                                + times(1001, i -> "- {name: p" + i + ", kind: body, unit: foo}\n"),
                        problems,
                        new Allowance(YamlReader.MAX_VALUES));
        WorldFileException refused =
                catchThrowableOfType(
                        WorldFileException.class,
                        () ->
                                new PrototypeReader(problems)
                                        .read(
                                                list,
                                                List.copyOf(
                                                        list.get("properties")
                                                                .orElseThrow()
                                                                .children()),
                                                List.of(),
                                                List.of(),
                                                List.of()));
        assertThat(refused.problems())
                .extracting(Problem::toString)
                .containsExactly(
                        "w:1002:3: properties: found 1001 in all files, expected at most 1000");
    }

    /** The name's formula also has a mistake in each repetition. An evaluation would report it. */
    @Test
    void formulasAreCountedBeforeAnyIsWorkedOut() {
        assertThat(
                        problems(
                                START
                                        + "items: [{name: 'a{1/0}', repeat: 20000, semantic: {x: '"
                                        + "{i} ".repeat(16_000)
                                        + "'}}]\n"))
                .singleElement()
                .satisfies(
                        problem ->
                                assertThat(problem.toString())
                                        .startsWith("w:3:9: more than 10000000 formulas"));
    }

    @Test
    void theLengthOfATextThatFormulasMakeIsCheckedAtTheFirstRepetition() {
        assertThat(
                        problems(
                                START
                                        + "items: [{name: 'a{i}', repeat: 3, semantic: {x: '"
                                        + "{i} ".repeat(3_000)
                                        + "'}}]\n"))
                .singleElement()
                .satisfies(
                        problem ->
                                assertThat(problem.message())
                                        .contains(
                                                "x: formulas make a text of more than 4096"
                                                        + " characters where i = 0"));
        assertThat(
                        problems(
                                START
                                        + "items: [{name: 'a{i}', repeat: 3, semantic: {x: '"
                                        + "{i} ".repeat(2_000)
                                        + "'}}]\n"))
                .isEmpty();
    }

    @Test
    void whatWasMeantIsLookedForOnlySoOften() {
        List<Problem> problems =
                problems(
                        START
                                + "items:\n"
                                + times(1000, i -> "- {name: body-" + i + ", physics: {mass: 1}}\n")
                                + times(
                                        5000,
                                        i ->
                                                "- {name: s"
                                                        + i
                                                        + ", kind: spring, physics: {end1: bodi-"
                                                        + i % 1000
                                                        + ", end2: bodj-"
                                                        + i % 1000
                                                        + "}}\n"));
        assertThat(problems).hasSize(Problems.MAX_REPORTED + 1);
        assertThat(problems)
                .filteredOn(problem -> problem.message().contains("did you mean"))
                .hasSize(Problems.MAX_SUGGESTIONS);
    }

    /** Repetitions of an item, and items that are like a prefab, share one list of actions. */
    @Test
    void actionsAndSymbolsOfAPrefabAreReadOnce() throws WorldFileException {
        String prefab =
                START
                        + "prefabs:\n"
                        + "  p:\n"
                        + "    physics: {mass: 0}\n"
                        + "    semantic: {a: [1, 2]}\n"
                        + "    physical: {shape: mesh, vertices: [[0,0,0],[1,0,0],[0,1,0]],"
                        + " triangles: [[0,1,2]]}\n"
                        + "    access:\n"
                        + times(300, i -> "      a" + i + ": {effects: [{impulse: [1, 0, 0]}]}\n");
        for (String items :
                List.of(
                        "- {name: 'b{i}', like: p, repeat: 50}\n",
                        times(
                                50,
                                i ->
                                        "- {name: b"
                                                + i
                                                + ", like: p, physics: {charge: "
                                                + i
                                                + "}}\n"))) {
            WorldDescription world =
                    WorldFile.parse(
                            "w", (prefab + "items:\n" + items).getBytes(StandardCharsets.UTF_8));
            ItemDefinition first = world.items().getFirst();
            assertThat(first.actions()).hasSize(300);
            assertThat(world.items())
                    .hasSize(50)
                    .allSatisfy(
                            item -> {
                                assertThat(item.actions()).isSameAs(first.actions());
                                assertThat(item.symbols()).isSameAs(first.symbols());
                                assertThat(item.shape()).isSameAs(first.shape());
                            });
            assertThat(world.warnings()).as("each impulse moves nothing").hasSize(100);
        }
    }

    /** Items that change one of 300 actions share the 299 others. */
    @Test
    void actionsThatAnItemDoesNotChangeAreReadOnce() throws WorldFileException {
        List<ItemDefinition> items =
                read(
                        START
                                + "prefabs:\n  p:\n    access:\n"
                                + times(300, i -> "      a" + i + ": {effects: [{raise: b}]}\n")
                                + "items:\n"
                                + times(
                                        50,
                                        i ->
                                                "- {name: b"
                                                        + i
                                                        + ", like: p, access: {a7: {doc: d"
                                                        + i
                                                        + "}}}\n")
                                + "- {name: 'c{i}', like: p, repeat: 50, "
                                + "access: {a7: {doc: 'd{i}'}}}\n");
        ItemDefinition first = items.getFirst();
        assertThat(items)
                .hasSize(100)
                .allSatisfy(
                        item -> {
                            assertThat(item.actions())
                                    .extracting(Action::name)
                                    .containsExactlyElementsOf(
                                            first.actions().stream().map(Action::name).toList());
                            assertThat(item.actions().get(8)).isSameAs(first.actions().get(8));
                        });
        assertThat(items)
                .extracting(item -> item.actions().get(7).doc())
                .startsWith("d0", "d1", "d2")
                .endsWith("d48", "d49");
    }

    /** Each family of repetitions would have 20 million values or more. */
    @ParameterizedTest
    @CsvSource(
            delimiter = '!',
            textBlock =
                    """
                    items: [{name: 'b{i}', repeat: 5000, access: {               ! a%d: {effects: [{raise: b}]},  ! z: {doc: 'b{i}', effects: [{raise: b}]}}}]
                    items: [{name: 'b{i}', repeat: 20000, physical: {shape: sphere, radius: '{1+i}'}, access: { ! a%d: {effects: [{raise: b}]},  ! }}]
                    items: [{name: 'b{i}', repeat: 20000, physical: {shape: sphere, radius: '{1+i}'}, semantic: { ! s%d: 1,  ! }}]
                    items: [{name: 'b{i}', repeat: 20000, physical: {material: {roughness: '{1/(1+i)}'}, shape: mesh, triangles: [[0, 1, 2]], vertices: [ ! '[%d,0,0],' ! ]}}]
                    """)
    void whatIsReadForEachItemIsCounted(String begin, String piece, String end) {
        assertThat(problems(START + begin + times(1000, piece::formatted) + end + "\n"))
                .singleElement()
                .asString()
                .startsWith("w:3:")
                .contains(
                        "more than 2000000 in all items",
                        "into a prefab that the items are `like`");
    }

    @Test
    void whatItemsThatAreLikeAPrefabChangeIsCounted() {
        assertThat(
                        problems(
                                START
                                        + "prefabs: {p: {access: {a: {effects: ["
                                        + times(60, i -> "{raise: b" + i + ", with: {x: 1}},")
                                        + "]}}}}\nitems:\n"
                                        + times(
                                                10_000,
                                                i ->
                                                        "- {name: b"
                                                                + i
                                                                + ", like: p, access: {a: {doc:"
                                                                + " d}}}\n")))
                .singleElement()
                .asString()
                .startsWith("w:")
                .contains("a: actions, symbols");
    }

    /** 10,000 items that change an action, a symbol and a place of a usual prefab. */
    @Test
    void changesToAUsualPrefabStayWithinTheLimit() throws WorldFileException {
        assertThat(
                        read(
                                START
                                        + "prefabs:\n  p:\n    access:\n"
                                        + times(
                                                10,
                                                i ->
                                                        "      a"
                                                                + i
                                                                + ": {parameters: {x: {min: 0, max:"
                                                                + " 1}}, effects: [{symbol: s0, to:"
                                                                + " $x}]}\n")
                                        + "    semantic:\n"
                                        + times(10, i -> "      s" + i + ": 1\n")
                                        + "items:\n"
                                        + times(
                                                10_000,
                                                i ->
                                                        "- {name: b"
                                                                + i
                                                                + ", like: p, access: {a3: {doc: d"
                                                                + i
                                                                + "}}, semantic: {s1: "
                                                                + i
                                                                + "}, physical: {location: ["
                                                                + i
                                                                + ", 0, 0]}}\n")))
                .hasSize(10_000);
    }

    /** In an earlier version, a mapping of any size that was built again counted as one value. */
    @Test
    void whatRepetitionsCopyIsCounted() {
        assertThat(
                        problems(
                                START
                                        + "prefabs: {p: {access: {"
                                        + times(4000, i -> "a" + i + ": {effects: [{raise: b}]},")
                                        + "}}}\nitems: [{name: 'b{i}', like: p, "
                                        + "repeat: 100000, access: {a0: {doc: 'd{i}'}}}]\n"))
                .singleElement()
                .asString()
                .contains("more than 10000000 values");
    }

    /**
     * An item's own values are not shared. Values that are only partly equal to those of the prefab
     * are not shared either.
     */
    @Test
    void whatAnItemAddsToAPrefabIsItsOwn() throws WorldFileException {
        List<ItemDefinition> items =
                read(
                        START
                                + "prefabs:\n"
                                + "  p: {semantic: {a: 1}, physics: {mass: 1}}\n"
                                + "  q: {like: p, semantic: {b: 2}}\n"
                                + "items:\n"
                                + "- {name: x, like: p}\n"
                                + "- {name: y, like: q}\n"
                                + "- {name: z, like: q, semantic: {a: 3}}\n"
                                + "- {name: u, like: p, physics: {mass: 2}}\n");
        assertThat(items)
                .extracting(item -> item.symbols().toString())
                .containsExactly("{a=1.0}", "{a=1.0, b=2.0}", "{a=3.0, b=2.0}", "{a=1.0}");
        assertThat(items)
                .extracting(item -> item.physics("mass").orElseThrow()[0])
                .containsExactly(1.0, 1.0, 1.0, 2.0);
    }

    /**
     * In an earlier version, a million repetitions of 300 actions took 25 times as long as a
     * million repetitions of 3 actions.
     */
    @Test
    void actionsOfRepetitionsCostNothing() throws Exception {
        assertThat(growth(8, () -> nanoseconds(repeated(300)), () -> nanoseconds(repeated(3))))
                .isLessThan(8);
    }

    private static String repeated(int actions) {
        return START
                + "prefabs:\n  p:\n    access:\n"
                + times(actions, i -> "      a" + i + ": {effects: [{raise: b}]}\n")
                + "items:\n"
                + "- {name: 'b{i}', like: p, repeat: 100000}\n";
    }

    /** Eight times the size takes little more than eight times the time, not sixty-four times. */
    @ParameterizedTest
    @CsvSource(
            delimiter = '!',
            textBlock =
                    """
                    items: [{name: a, access: { ! a%d: {effects: [{raise: b}]},            ! '}}]'
                    items: [{name: a, semantic: { ! %2$s: 1,                               ! '}}]'
                    items: [                    ! '{name: %2$s},'                          ! ']'
                    prefabs: {                  ! '%2$s: {physics: {mass: 1, charge: 2}},' ! '}'
                    """)
    void timeGrowsAsTheFile(String begin, String piece, String end) throws Exception {
        String small = START + begin + times(4000, i -> piece(piece, i)) + end + "\n";
        String large = START + begin + times(32000, i -> piece(piece, i)) + end + "\n";
        assertThat(growth(30, () -> nanoseconds(large), () -> nanoseconds(small))).isLessThan(30);
    }

    /**
     * Returns the smallest ratio of five, because other work on the machine may disturb a
     * measurement.
     *
     * @param most ratio below which no further measurement is made
     */
    private static double growth(double most, Callable<Long> ofLarge, Callable<Long> ofSmall)
            throws Exception {
        double least = Double.MAX_VALUE;
        for (int attempt = 0; attempt < 5 && least >= most; attempt++) {
            least = Math.min(least, (double) ofLarge.call() / ofSmall.call());
        }
        return least;
    }

    /**
     * Each text is one value, comment or line of punctuation. A scanner could copy it for each
     * piece that it reads.
     */
    @ParameterizedTest
    @CsvSource(
            delimiter = '!',
            textBlock =
                    """
                    ''            ! :     ! ''
                    'doc: |   a'  ! 'a,'  ! ''
                    'doc: '       ! 'a,'  ! ''
                    'doc: '       ! 'a]'  ! ''
                    'doc: ['      ! 'a::,::::"'  ! ']'
                    'doc: '       ! '\\"\\uD800\\", ' ! ''
                    'doc: ['      ! '\\"\\uD800\\", ' ! ']'
                    'doc: a #'    ! 'b,'  ! ''
                    'doc: "'      ! 'a,'  ! '"'
                    'doc: !<'     ! 'a,'  ! '>'
                    'doc: &'      ! 'a:'  ! ' x'
                    """)
    void timeGrowsAsOneValue(String begin, String piece, String end) throws Exception {
        String opening = START + begin.replace("   ", "\n   ");
        String small = opening + piece.repeat(100_000 / piece.length()) + end;
        String large = opening + piece.repeat(800_000 / piece.length()) + end;
        assertThat(growth(30, () -> nanosecondsToRefuse(large), () -> nanosecondsToRefuse(small)))
                .isLessThan(30);
    }

    /**
     * In an earlier version, the scanner read the indentation of the line again for each bracket.
     */
    @Test
    void timeOfAnUnclosedBracketGrowsAsTheFile() throws Exception {
        String line = START + "doc:\n" + " ".repeat(30_000);
        assertThat(
                        growth(
                                30,
                                () -> nanosecondsToRefuse(line + "[" + "[],".repeat(80_000)),
                                () -> nanosecondsToRefuse(line + "[" + "[],".repeat(10_000))))
                .isLessThan(30);
    }

    private static long nanosecondsToRefuse(String text) {
        return least(() -> problems(text));
    }

    /** Returns a piece with a number in it, or with one of 2^16 names that have the same hash. */
    private static String piece(String piece, int number) {
        return piece.formatted(
                number,
                IntStream.range(0, 16)
                        .mapToObj(bit -> (number >> bit & 1) == 0 ? "Aa" : "BB")
                        .collect(Collectors.joining()));
    }

    private static long nanoseconds(String text) throws WorldFileException {
        read(text);
        return least(() -> problems(text));
    }

    /** Returns the least of three measurements of the processor time of this thread. */
    private static long least(Runnable work) {
        var threads = ManagementFactory.getThreadMXBean();
        long least = Long.MAX_VALUE;
        for (int i = 0; i < 3; i++) {
            long begin = threads.getCurrentThreadCpuTime();
            work.run();
            least = Math.min(least, threads.getCurrentThreadCpuTime() - begin);
        }
        return least;
    }
}
