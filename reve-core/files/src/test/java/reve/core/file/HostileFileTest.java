// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.Assertions;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.Arguments;
import org.junit.jupiter.params.provider.MethodSource;

import java.io.IOException;
import java.io.RandomAccessFile;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.stream.Stream;

/** Each malicious file gets one clear message. */
class HostileFileTest {
    private static final String START = "reve: 1\nname: w\n";

    /**
     * Far more time than a refusal takes, and far less than the attackers want (minutes,
     * gigabytes).
     */
    private static final Duration PATIENCE = Duration.ofMinutes(5);

    static Stream<Arguments> attacks() {
        String piece = "more than 65536 characters in one piece; is this a world file?";
        String deep = "nested deeper than 32 levels";
        return Stream.of(
                attack(
                        "alias bomb",
                        "a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n",
                        "1:4: anchors (`&a`) are not allowed; write values out where they are "
                                + "used"),
                attack(
                        "alias to nothing",
                        "a: *b\n",
                        "1:4: aliases (`*b`) are not allowed; " + "write the value out"),
                attack(
                        "alias as key",
                        "*k : 1\n",
                        "1:1: aliases (`*k`) are not allowed; " + "write the value out"),
                attack(
                        "java tag",
                        "a: !!java.io.File []\n",
                        "1:4: tags (`tag:yaml.org,2002:"
                                + "java.io.File`) are not allowed; write the value only"),
                attack(
                        "private tag",
                        START + "doc: !x y\n",
                        "3:6: tags (`!x`) are not allowed; write the value only"),
                attack(
                        "list as key",
                        "? [1, 2]\n: 3\n",
                        "1:3: a key must be a name, found a list or a mapping"),
                attack(
                        "two documents",
                        START + "---\n" + START,
                        "3:1: a second document begins here; a file holds one world"),
                attack(
                        "other YAML",
                        "%YAML 3.0\n---\n" + START,
                        "1:1: written for another YAML " + "version; remove the line `%YAML`"),
                attack("deep lists", "a: " + "[".repeat(4_000_000), "1:35: " + deep),
                attack("deep mappings", "{a: ".repeat(1_000_000), "1:129: " + deep),
                attack("deep blocks", blocks(2000), "33:33: " + deep),
                attack(
                        "deep lists in an item",
                        START + "items:\n- name: a\n  semantic: {x: " + "[".repeat(1_000_000),
                        "5:45: " + deep),
                attack(
                        "anchor in a prefab",
                        START + "prefabs:\n  a: &a {kind: body}\n  b: *a\n",
                        "4:6: anchors (`&a`) are not allowed; write values out where they are "
                                + "used"),
                attack(
                        "long formula",
                        START
                                + "items:\n- name: a{i}\n  repeat: 3\n  physical: "
                                + "{location: [\"{"
                                + "(".repeat(600)
                                + "}\", 0, 0]}\n",
                        "6:25: location[0]: formula `"
                                + "(".repeat(47)
                                + "…` is longer than 512 characters"),
                attack(
                        "eight times 10^7",
                        START
                                + "items:\n- name: a-{a}\n  repeat: {a: 10000000, "
                                + "b: 10000000, c: 10000000, d: 10000000, e: 10000000, f: 10000000, "
                                + "g: 10000000, h: 10000000}\n",
                        "4:3: more than 1000000 items with " + "their repetitions"),
                attack("dashes on a line", "- ".repeat(500_000), "1:1: " + piece),
                attack("one long word", "x".repeat(4_000_000), "1:1: " + piece),
                attack("blanks", " ".repeat(4_000_000), "1:1: " + piece),
                attack("one long key", "k".repeat(3_000_000) + ": 1\n", "1:1: " + piece),
                attack(
                        "one long number",
                        START + "frame: {rate: " + "9".repeat(3_000_000) + "}\n",
                        "3:14: " + piece),
                attack(
                        "one text of many lines",
                        START + "doc: |\n" + "  xxxxxxx\n".repeat(100_000),
                        "3:6: a text of 800000 characters; at most 65536 are allowed"),
                attack(
                        "too many values",
                        "items: [" + "1,".repeat(3_000_000),
                        "1:4000005: more than 2000000 values in all"),
                attack(
                        "too many values outside of items",
                        "a: [" + "1,".repeat(3_000_000),
                        "1:1000001: more than 500000 values outside of `items`"),
                attack(
                        "too many keys",
                        keys(1_000_000),
                        "65537:1: a mapping of more than 65536 keys"),
                attack(
                        "open quote",
                        START + "doc: \"" + "x\n".repeat(100_000),
                        "3:6: `\"` is " + "not closed, which was noticed on line 100003"),
                attack(
                        "open brace",
                        "a: {" + "\n".repeat(1_000_000),
                        "1:4: `{` is not closed, " + "which was noticed on line 1000001"),
                attack(
                        "tab",
                        START + "items:\n\t- a\n",
                        "4:1: not valid YAML: while scanning for "
                                + "the next token, found character '\\t(TAB)' that cannot start any "
                                + "token. (Do not use \\t(TAB) for indentation)"),
                attack(
                        "bad indentation",
                        "a: 1\n  b: 2\n",
                        "2:4: not valid YAML: a `:` makes no key here; put a text that holds `: ` "
                                + "in quotes, and begin all keys of a mapping in one column"),
                attack(
                        "zero byte",
                        START + "doc: a\0b\n",
                        "3:7: the character U+0000 is not allowed in a world file"),
                attack(
                        "empty",
                        "",
                        "1:1: the file is empty; a world begins with `reve: 1` and a " + "`name`"),
                attack(
                        "comments only",
                        "# hi\n".repeat(100_000),
                        "1:1: the file is empty; a world " + "begins with `reve: 1` and a `name`"),
                attack(
                        "a list",
                        "- 1\n",
                        "1:1: found a list of 1, expected a mapping that begins "
                                + "with `reve: 1` and a `name`"),
                attack(
                        "nested quantifier",
                        START + "constants: {softening: " + "9".repeat(60_000) + "x}\n",
                        "3:24: softening: found a text of 60001 characters, expected a "
                                + "number in m"),
                attack(
                        "open brackets as unit",
                        START + "constants: {softening: 1 " + "(".repeat(900) + "}\n",
                        "3:24: softening: unit `"
                                + "(".repeat(64)
                                + "…`: it is longer than 255 characters"));
    }

    private static Arguments attack(String name, String text, String message) {
        return Arguments.of(name, text, message);
    }

    private static String keys(int count) {
        var text = new StringBuilder();
        for (int i = 0; i < count; i++) {
            text.append('k').append(i).append(": 1\n");
        }
        return text.toString();
    }

    private static String blocks(int depth) {
        var text = new StringBuilder();
        for (int i = 0; i < depth; i++) {
            text.append(" ".repeat(i)).append("a:\n");
        }
        return text.toString();
    }

    private static WorldFileException refused(byte[] content) {
        return Assertions.assertTimeoutPreemptively(
                PATIENCE,
                () ->
                        catchThrowableOfType(
                                WorldFileException.class, () -> WorldFile.parse("w", content)));
    }

    @ParameterizedTest(name = "{0}")
    @MethodSource("attacks")
    void getsOneClearMessage(String name, String text, String message) {
        WorldFileException refused = refused(text.getBytes(StandardCharsets.UTF_8));
        assertThat(refused.problems()).hasSize(1);
        assertThat(refused).hasMessage("w:" + message);
    }

    /** The YAML library reads pieces of 1,025 characters, and it counts such a character as two. */
    @Test
    void charactersBeyond16BitsMayStandAnywhere() throws WorldFileException {
        for (int before = 1000; before < 1050; before++) {
            String doc = "x".repeat(before) + "\ud83d\ude00".repeat(3000);
            String text = START + "doc: " + doc + "\n";
            assertThat(WorldFile.parse("w", text.getBytes(StandardCharsets.UTF_8)).doc())
                    .isEqualTo(doc);
        }
    }

    @Test
    void bytesThatAreNotUtf8AreRefusedWhereTheyStand() {
        assertThat(refused(new byte[] {'a', ':', '\n', 'b', (byte) 0xff}))
                .hasMessage("w:2:2: not UTF-8 text from here on; save the file as UTF-8");
        assertThat(refused(START.getBytes(StandardCharsets.UTF_16)))
                .hasMessage("w:1:1: not UTF-8 text from here on; save the file as UTF-8");
        assertThat(refused(new byte[] {'a', (byte) 0xc3}))
                .as("cut within a character")
                .hasMessage("w:1:2: not UTF-8 text from here on; save the file as UTF-8");
    }

    @Test
    void keysOfOneHashAreReadInReasonableTime() {
        var text = new StringBuilder(START);
        for (int i = 0; i < 1 << 14; i++) {
            for (int bit = 0; bit < 14; bit++) {
                text.append((i >> bit & 1) == 0 ? "Aa" : "BB");
            }
            text.append(": 1\n");
        }
        assertThat(refused(text.toString().getBytes(StandardCharsets.UTF_8)).problems())
                .hasSize(Problems.MAX_REPORTED + 1);
    }

    @Test
    void messagesCannotControlTheTerminal() {
        for (String text :
                new String[] {
                    "\"\\e[31m\": 1\n",
                    "prototype: \"\\e[31m\"\n",
                    "constants: {softening: \"3 \\e[31m\"}\n",
                    "items: [{name: \"\\e[31m\"}]\n",
                    "laws: [{name: a, parameters: {\"\\e\": \"\\x07\"}}]\n"
                }) {
            assertThat(refused((START + text).getBytes(StandardCharsets.UTF_8)).getMessage())
                    .as(text)
                    .doesNotContainPattern("\\p{Cc}");
        }
    }

    @Test
    void manyWrongEntriesAreCutShort() {
        for (String text :
                new String[] {
                    "laws: [" + "1,".repeat(300_000) + "]\n",
                    "items: [" + "1,".repeat(300_000) + "]\n",
                    "k: 1\n".repeat(300_000)
                }) {
            assertThat(refused((START + text).getBytes(StandardCharsets.UTF_8)).problems())
                    .hasSize(Problems.MAX_REPORTED + 1);
        }
    }

    @Test
    void onlyRegularFilesOfReasonableSizeAreOpened(@TempDir Path folder) throws Exception {
        Path large = folder.resolve("large.yaml");
        try (var file = new RandomAccessFile(large.toFile(), "rw")) {
            file.setLength(SourceText.MAX_BYTES + 1L);
        }
        Path fifo = folder.resolve("fifo");
        assertThat(new ProcessBuilder("mkfifo", fifo.toString()).start().waitFor()).isZero();

        assertThat(refusedFile(large))
                .isEqualTo(
                        "larger than 16 MiB, the limit for a world file with all that it includes");
        assertThat(refusedFile(fifo)).isEqualTo("not a regular file");
        assertThat(refusedFile(Path.of("/dev/zero"))).isEqualTo("not a regular file");
        assertThat(refusedFile(folder)).isEqualTo("a folder; name the world file in it");
        assertThat(refusedFile(folder.resolve("none"))).isEqualTo("there is no such file");
    }

    @Test
    void linkToAWorldFileIsFollowed(@TempDir Path folder) throws IOException, WorldFileException {
        Path file = Files.writeString(folder.resolve("w.yaml"), START);
        Path link = Files.createSymbolicLink(folder.resolve("link.yaml"), file);
        assertThat(WorldFile.load(link).name()).isEqualTo("w");
    }

    private static String refusedFile(Path path) {
        WorldFileException refused =
                Assertions.assertTimeoutPreemptively(
                        PATIENCE,
                        () ->
                                catchThrowableOfType(
                                        WorldFileException.class, () -> WorldFile.load(path)));
        assertThat(refused.problems()).hasSize(1);
        assertThat(refused.problems().getFirst().file()).isEqualTo(path.toString());
        return refused.problems().getFirst().message();
    }
}
