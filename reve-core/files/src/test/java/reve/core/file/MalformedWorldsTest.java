// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.assertj.core.api.SoftAssertions;
import org.junit.jupiter.api.BeforeAll;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;
import org.junit.jupiter.params.provider.ValueSource;

import java.io.IOException;
import java.io.InputStream;
import java.lang.management.ManagementFactory;
import java.lang.management.ThreadMXBean;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Objects;

/**
 * Every malformed world is refused quickly, with the right place and a short message in plain
 * words.
 */
class MalformedWorldsTest {
    private static final int MOST_PROBLEMS = 3;
    private static final long MOST_NANOSECONDS = 100_000_000;
    private static final String ITEM = "reve: 1\nname: w\nitems:\n- name: one\n  ";

    /** The text before and after a snippet. */
    private static final Map<String, List<String>> CONTEXTS =
            Map.ofEntries(
                    Map.entry("raw", List.of("", "")),
                    Map.entry("top", List.of(ITEM + "physics: {mass: 1}\n", "\n")),
                    Map.entry("item", List.of(ITEM, "\n")),
                    Map.entry("phys", List.of(ITEM + "physics: {", "}\n")),
                    Map.entry("physical", List.of(ITEM + "physical: {", "}\n")),
                    Map.entry("semantic", List.of(ITEM + "semantic: {", "}\n")),
                    Map.entry("sensor", List.of(ITEM + "sensors: {eye: {", "}}\n")),
                    Map.entry(
                            "action",
                            List.of(
                                    ITEM
                                            + "physics: {mass: 1}\n  access:\n    push:\n"
                                            + "      effects: [{raise: a}]\n      ",
                                    "\n")),
                    Map.entry(
                            "effect",
                            List.of(
                                    ITEM
                                            + "physics: {mass: 1}\n"
                                            + "  access:\n"
                                            + "    push:\n"
                                            + "      parameters: {p: {type: text}}\n"
                                            + "      effects:\n"
                                            + "      - ",
                                    "\n")),
                    Map.entry(
                            "prefab",
                            List.of(ITEM + "physics: {mass: 1}\nprefabs:\n  p: {", "}\n")),
                    Map.entry(
                            "repeat",
                            List.of(
                                    "reve: 1\nname: w\nitems:\n- name: b{i}\n  repeat: 3\n  ",
                                    "\n")));

    /**
     * Names of classes and packages, stack traces, and folders of a build. No message may have
     * them.
     */
    private static final String INNARDS =
            "(?i)\\b(java|javax|reve|de|com|org|tools|dev)\\.[a-z]+\\.[\\w.]*[A-Z]|\\w+Exception|\\bat"
                    + " [a-z]+\\.|build/|\\.java\\b|\\bnull\\b";

    private static List<Malformed> worlds;

    /** A text that is refused, the place of the problem, and a part of its message. */
    private record Malformed(String row, String text, int line, int column, String message) {}

    @BeforeAll
    static void readTable() throws IOException {
        try (InputStream in =
                Objects.requireNonNull(
                        MalformedWorldsTest.class.getResourceAsStream("/malformed-worlds.txt"))) {
            worlds =
                    new String(in.readAllBytes(), StandardCharsets.UTF_8)
                            .lines()
                            .filter(row -> !row.startsWith("#"))
                            .map(MalformedWorldsTest::world)
                            .toList();
        }
        worlds.forEach(
                world -> refusal(world.text)); // loads the classes that the first refusals need
    }

    private static Malformed world(String row) {
        int bar = row.indexOf(" | ");
        int arrow = row.lastIndexOf(" => ");
        String message = row.substring(arrow + 4);
        List<String> context = CONTEXTS.get(row.substring(0, bar));
        String marked =
                context.getFirst() + unescaped(row.substring(bar + 3, arrow)) + context.getLast();
        if (message.startsWith("@")) {
            String[] place = message.substring(1, message.indexOf(' ')).split(":");
            return new Malformed(
                    row,
                    marked,
                    Integer.parseInt(place[0]),
                    Integer.parseInt(place[1]),
                    message.substring(message.indexOf(' ') + 1));
        }
        String before = marked.substring(0, marked.indexOf('»'));
        return new Malformed(
                row,
                marked.replace("»", ""),
                1 + (int) before.chars().filter(c -> c == '\n').count(),
                before.length() - before.lastIndexOf('\n'),
                message);
    }

    private static String unescaped(String snippet) {
        return snippet.replace("\\\\", "\u0001")
                .replace("\\n", "\n")
                .replace("\\t", "\t")
                .replace('\u0001', '\\');
    }

    private static List<Problem> refusal(String text) {
        WorldFileException refused =
                catchThrowableOfType(
                        WorldFileException.class,
                        () -> WorldFile.parse("w", text.getBytes(StandardCharsets.UTF_8)));
        return refused == null ? List.of() : refused.problems();
    }

    @Test
    void eachIsRefusedWhereItIsWrong() {
        var all = new SoftAssertions();
        assertThat(worlds).as("malformed worlds").hasSizeGreaterThan(700).doesNotHaveDuplicates();
        for (Malformed world : worlds) {
            all.assertThat(refusal(world.text))
                    .as(world.row)
                    .hasSizeBetween(1, MOST_PROBLEMS)
                    .anySatisfy(
                            problem -> {
                                assertThat(problem.line()).as("line").isEqualTo(world.line);
                                assertThat(problem.column()).as("column").isEqualTo(world.column);
                                assertThat(problem.message()).contains(world.message);
                            });
        }
        all.assertAll();
    }

    @Test
    void messagesAreShortAndTellNothingOfTheProgram() {
        var all = new SoftAssertions();
        for (Malformed world : worlds) {
            for (Problem problem : refusal(world.text)) {
                all.assertThat(problem.message())
                        .as(world.row)
                        .hasSizeBetween(8, 400)
                        .doesNotContainPattern("[\\p{Cc}\\p{Zl}\\p{Zp}\\u202a-\\u202e]")
                        .doesNotContainPattern(INNARDS);
            }
        }
        all.assertAll();
    }

    /** Processor time of this thread, which other processes do not lengthen. */
    @Test
    void eachIsRefusedWithinATenthOfASecond() {
        ThreadMXBean threads = ManagementFactory.getThreadMXBean();
        List<String> slow = new ArrayList<>();
        for (Malformed world : worlds) {
            long least = Long.MAX_VALUE; // the first attempt may load classes
            for (int i = 0; i < 20 && least > MOST_NANOSECONDS; i++) {
                long before = threads.getCurrentThreadCpuTime();
                refusal(world.text);
                least = Math.min(least, threads.getCurrentThreadCpuTime() - before);
            }
            if (least > MOST_NANOSECONDS) {
                slow.add(world.row);
            }
        }
        assertThat(slow).isEmpty();
    }

    /**
     * Wrong files beside the world. The problem is reported at line 6, where the world names them.
     */
    @ParameterizedTest(name = "{0}: {1}")
    @CsvSource(
            delimiter = '!',
            quoteCharacter = '\'',
            textBlock =
                    """
                    a.obj   ! v 0 zero 1       ! line 1: `zero` is no number
                    a.obj   ! v 0 0            ! line 1: `v` has too few numbers
                    a.obj   ! v 0 0 0|f 1 2    ! there are no triangles in it
                    a.obj   ! v 0 0 0|f a b c  ! line 2: `a` is no corner of a face
                    a.obj   ! v 0 0 0|f 1/x 1 1! line 2: `1/x` is no corner of a face
                    a.obj   ! v 0 0 0|f 1 2 3  ! a face refers to vertex 2, there are 1
                    a.obj   ! v 1e999 0 0|v 0 1 0|v 0 0 1|f 1 2 3 ! expected a finite number
                    a.obj   ! v 0 0 0|vt x|f 1 1 1 ! line 2: `x` is no number
                    a.obj   ! ''               ! a.obj:
                    a.obj   ! mtllib no.mtl|v 0 0 0|v 0 1 0|v 0 0 1|f 1 2 3 ! no.mtl
                    a.gltf  ! ''               ! a.gltf: not glTF
                    a.gltf  ! {"asset": 3}     ! a.gltf:
                    a.gltf  ! {"asset"         ! a.gltf: line 1: not JSON
                    a.glb   ! glTF             ! a.glb: expected glTF of version 2
                    a.stl   ! solid            ! a.stl: expected a mesh in a .glb, .gltf, .obj or .dae file
                    none    ! ''               ! b.obj
                    """)
    void modelsAreRefusedInPlainWords(
            String file, String content, String message, @TempDir Path folder) throws IOException {
        Files.writeString(folder.resolve(file), content.replace('|', '\n'));
        Path world =
                Files.writeString(
                        folder.resolve("world.yaml"),
                        ITEM
                                + "physical:\n    shape: mesh\n    file: "
                                + (file.equals("none") ? "b.obj" : file)
                                + "\n");
        WorldFileException refused =
                catchThrowableOfType(WorldFileException.class, () -> WorldFile.load(world));
        assertThat(refused.problems())
                .singleElement()
                .satisfies(
                        problem -> {
                            assertThat(problem.line()).isEqualTo(7);
                            assertThat(problem.column()).isEqualTo(11);
                            assertThat(problem.message())
                                    .contains(message)
                                    .doesNotContainPattern(INNARDS);
                        });
    }

    /** An included file, and the table from which an item is repeated. */
    @ParameterizedTest(name = "{0}: {1}")
    @CsvSource(
            delimiter = '!',
            quoteCharacter = '\'',
            textBlock =
                    """
                    parts.yaml ! frame: {rate: 60}           ! parts.yaml:1:1: unknown key `frame`
                    parts.yaml ! laws: [a                    ! parts.yaml:1:7: `[` is not closed
                    parts.yaml ! items: [{nam: b}]           ! parts.yaml:1:10: unknown key `nam`; did you mean
                    parts.yaml ! prefabs: {p: {kind: sprung}} ! parts.yaml:1:21: kind: no properties are declared
                    parts.yaml ! include: [parts.yaml]       ! parts.yaml:1:11: include[0]
                    suns.csv   ! ''                          ! suns.csv:1:1:
                    suns.csv   ! x,y|1                       ! suns.csv:2:
                    suns.csv   ! x,y|1,z                     ! suns.csv:2:
                    suns.csv   ! x,x|1,2                     ! suns.csv:1:
                    suns.csv   ! x|Infinity                  ! suns.csv:2:
                    """)
    void filesThatAWorldNamesAreRefusedAtTheirOwnPlaces(
            String file, String content, String problem, @TempDir Path folder) throws IOException {
        Files.writeString(folder.resolve(file), content.replace('|', '\n'));
        Path world =
                Files.writeString(
                        folder.resolve("world.yaml"),
                        file.endsWith(".csv")
                                ? "reve: 1\nname: w\nitems:\n- {name: 'b{i}', repeat: suns.csv}\n"
                                : "reve: 1\nname: w\ninclude: [parts.yaml]\n");
        WorldFileException refused =
                catchThrowableOfType(WorldFileException.class, () -> WorldFile.load(world));
        assertThat(refused.problems())
                .hasSizeLessThanOrEqualTo(MOST_PROBLEMS)
                .anySatisfy(
                        each ->
                                assertThat(
                                                each.toString()
                                                        .substring(folder.toString().length() + 1))
                                        .startsWith(problem));
        assertThat(refused.getMessage().replace(folder.toString(), ""))
                .doesNotContainPattern(INNARDS);
    }

    /** Names in all scripts that do not deceive, and emoji. A name stays as it was written. */
    @ParameterizedTest
    @ValueSource(
            strings = {
                "duck",
                "Duck 2",
                "left wheel",
                "a-b_c.d",
                "x+y=z",
                "50 % (half)",
                "Ente",
                "Größe",
                "naïve café",
                "Œuvre",
                "señor",
                "smörgåsbord",
                "žluťoučký kůň",
                "İstanbul",
                "Þór",
                "Tiếng Việt",
                "утка",
                "Щёлк 1",
                "качка їжак",
                "πάπια",
                "Ωμέγα",
                "մկնիկ",
                "იხვი",
                "ברווז",
                "עט לבן",
                "بطة",
                "اردک",
                "می‌خواهم",
                "کتاب‌خانه",
                "बत्तख़",
                "क्‍ष",
                "হাঁস",
                "ਬਤਖ਼",
                "બતક",
                "வாத்து",
                "బాతు",
                "ಬಾತುಕೋಳಿ",
                "താറാവ്",
                "ශ්‍රී",
                "เป็ด",
                "ເປັດ",
                "བྱ་རྒོད",
                "ဘဲ",
                "ទា",
                "ዳክዬ",
                "ᓂᖅᓕᖅ",
                "鸭子",
                "鴨",
                "葛󠄀",
                "田中　太郎",
                "アヒル",
                "あひる",
                "오리",
                "ᠨᠤᠭᠤᠰᠤ",
                "𐤁𐤓",
                "𓅭",
                "🦆",
                "👩‍🚀",
                "❤️",
                "Δt",
                "µ-sensor",
                "H₂O",
                "болт M8"
            })
    void namesOfAllScriptsAreValid(String name) throws WorldFileException {
        WorldDescription world =
                WorldFile.parse(
                        "w",
                        ("reve: 1\nname: w\nitems:\n- name: \"" + name + "\"\n- name: other\n")
                                .getBytes(StandardCharsets.UTF_8));
        assertThat(world.items().getFirst().name()).isEqualTo(name);
        assertThat(world.warnings()).isEmpty();
    }

    /** The world has two similar names on lines 4 and 5. */
    @ParameterizedTest(name = "{0} {1}")
    @CsvSource({
        "scope, ѕсоре",
        "paypal, раураl",
        "Alpha, Αlpha",
        "ball 1, bаll 1",
        "Oslo, Ⲟslo",
        "duck, dսck",
        "a b, a\u00a0b",
        "café, cafe\u0301",
        "葛, 葛󠄀",
        "ｄuck, duck",
        "ё, е\u0308",
        "می‌رود, میرود"
    })
    void namesThatLookAlikeAreWarnedOf(String one, String other) throws WorldFileException {
        WorldDescription world =
                WorldFile.parse(
                        "w",
                        ("reve: 1\nname: w\nitems:\n- name: \""
                                        + one
                                        + "\"\n- name: \""
                                        + other
                                        + "\"\n")
                                .getBytes(StandardCharsets.UTF_8));
        assertThat(world.warnings())
                .singleElement()
                .satisfies(
                        warning -> {
                            assertThat(warning.severity()).isEqualTo(Problem.Severity.WARNING);
                            assertThat(warning.line()).isBetween(4, 5);
                            assertThat(warning.toString())
                                    .startsWith("w:" + warning.line() + ":9: warning: ")
                                    .contains("looks like");
                        });
    }

    @Test
    void aWordOfMixedScriptsIsWarnedOfWithoutItsLookAlike() throws WorldFileException {
        assertThat(
                        WorldFile.parse(
                                        "w",
                                        "reve: 1\nname: w\nitems:\n- name: to раypal\n"
                                                .getBytes(StandardCharsets.UTF_8))
                                .warnings())
                .extracting(Problem::toString)
                .containsExactly(
                        "w:4:9: warning: name: `раypal` looks like `paypal`, but mixes "
                                + "letters of several scripts; write it in one");
    }

    @Test
    void aPushThatMovesNothingIsWarnedOf() throws WorldFileException {
        assertThat(
                        WorldFile.parse(
                                        "w",
                                        (ITEM
                                                        + "physics: {mass: 0}\n"
                                                        + "  access:\n"
                                                        + "    push:\n"
                                                        + "      effects:\n"
                                                        + "      - {impulse: [1, 0, 0]}\n")
                                                .getBytes(StandardCharsets.UTF_8))
                                .warnings())
                .extracting(Problem::toString)
                .containsExactly(
                        "w:9:19: warning: impulse: moves nothing as long as the item has "
                                + "mass 0");
    }

    /** A world is not refused because of values that laws wrote into it. */
    @Test
    void aWorldThatRanIsOnlyWarnedOf() throws WorldFileException {
        WorldDescription world =
                WorldFile.parse(
                        "w",
                        ("reve: 1\n"
                                        + "name: w\n"
                                        + "frame: {age: 9}\n"
                                        + "items:\n"
                                        + "- {name: a, physical: {location: [1e200, 0, 0]}, physics: {inertia:"
                                        + " [1, 1, 9], velocity: [1e-320, 0, 0]}}\n"
                                        + "forces: [{item: a, force: [1, 0, 0], frames: 3}]\n")
                                .getBytes(StandardCharsets.UTF_8));
        assertThat(world.warnings()).extracting(Problem::line).containsExactly(5, 5, 6);
        assertThat(world.items()).hasSize(1);
    }

    @Test
    void whatAStoreKeptIsTakenAsItIs() throws WorldFileException {
        assertThat(
                        WorldFile.parseItem(
                                        "kept",
                                        "{name: \"a\\u202eb \", physical: {location: [1e200, 0, 0],"
                                                + " material: {roughness: 1}}, physics: {inertia: [1,"
                                                + " 1, 9]}}",
                                        WorldFile.parse(
                                                        "w",
                                                        "reve: 1\nname: w\n"
                                                                .getBytes(StandardCharsets.UTF_8))
                                                .prototype())
                                .name())
                .isEqualTo("a\u202eb ");
    }

    @Test
    void aMillionItemsAreTakenAndOneMoreIsRefusedBeforeAnyIsMade() {
        assertThat(
                        refusal(
                                "reve: 1\nname: w\nitems:\n- {name: 'a{i}', repeat: 1000000}\n"
                                        + "- name: b\n"))
                .extracting(Problem::toString)
                .containsExactly("w:5:3: more than 1000000 items with their repetitions");
    }

    @Test
    void numbersOfDeclaredPropertiesAreLimited() {
        var world = new StringBuilder("reve: 1\nname: w\nproperties:\n");
        for (int i = 0; i < 200; i++) {
            world.append("- {name: p%d, kind: body, components: 16}\n".formatted(i));
        }
        world.append("items: [{name: 'a{i}', repeat: 16000}]\n");
        assertThat(refusal(world.toString()))
                .extracting(Problem::toString)
                .containsExactly(
                        "w:199:3: the declared properties up to this one need 50176000 numbers for"
                                + " all items (16 for each of 16000 items of kind body), at most"
                                + " 50000000; declare fewer properties or components, or make"
                                + " fewer items");
    }
}
