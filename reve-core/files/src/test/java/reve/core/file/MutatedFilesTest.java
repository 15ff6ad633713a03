// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.fail;

import org.junit.jupiter.api.Test;

import reve.core.Seed;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.util.List;
import java.util.Random;
import java.util.regex.Pattern;

/**
 * Inserts characters, pieces of YAML and bytes at random places of the project's world files. Each
 * mutated file must be valid, or be refused with a message that shows no internals of the program,
 * such as the name of a Java class. The seed is printed; {@code -Dreve.test.seed=N} repeats it, and
 * {@code -Dreve.test.mutants=20000} tests more.
 */
class MutatedFilesTest {
    private static final int MUTANTS = Integer.getInteger("reve.test.mutants", 400);

    /** Larger files would test nothing new and would take more time. */
    private static final int MAX_LENGTH = 4000;

    private static final String INNARDS =
            "\\b(java|javax|reve|de|com|org|tools|dev)\\.[a-z]+\\.|\\w+Exception|\\w+Error\\b|\\bat"
                    + " reve\\.|\\bnull\\b|\\[[BCDIJL][@;]|\\$\\$Lambda|Optional\\[|\\w+@[0-9a-f]{6}";

    /** The part of a message that quotes the file. */
    private static final Pattern QUOTED = Pattern.compile("`[^`]*`|\"[^\"]*\"");

    private static final List<String> PIECES =
            List.of(
                    "\"",
                    "'",
                    "\\",
                    "\"\\UFFFFFFFF\"",
                    "\\uD800",
                    "\\x",
                    "\\u00e9",
                    "\0",
                    "\u0001",
                    "\u0085",
                    "\u2028",
                    "\ufeff",
                    "\ud83d\ude00",
                    "\t",
                    "\n",
                    "\r",
                    "\n  ",
                    "\n- ",
                    " ",
                    ": ",
                    ":",
                    ", ",
                    "- ",
                    "? ",
                    "# ",
                    "| ",
                    "|9\n",
                    ">-\n",
                    "[",
                    "]",
                    "{",
                    "}",
                    "[[",
                    "{{",
                    "&a ",
                    "*a",
                    "!a ",
                    "!<%FF>",
                    "!!",
                    "%",
                    "%YAML 9.9",
                    "---\n",
                    "...\n",
                    "@",
                    "`",
                    "~",
                    "null",
                    "Null",
                    "true",
                    ".nan",
                    "-.inf",
                    "1e999",
                    "-1e-320",
                    "0x",
                    "0o",
                    "0xFFFFFFFFFFFFFFFFFF",
                    "9".repeat(40),
                    "1_000",
                    "2001-01-01",
                    "1 m",
                    "1 m^9999",
                    "1 kg*",
                    "°C",
                    "{i}",
                    "{1/0}",
                    "{",
                    "$",
                    "$x",
                    "$1/0",
                    "${",
                    "physics.mass",
                    "semantic.",
                    "actor",
                    "item",
                    "world",
                    "#zzz",
                    "../",
                    "/",
                    "\\\\",
                    "<<: ",
                    "=",
                    "reve: 1\n",
                    "name: ",
                    "items:\n",
                    "repeat: 3\n",
                    "like: x\n");

    @Test
    void noMessageTellsOfTheProgram() throws IOException {
        long seed = Seed.of("mutated files");
        var random = new Random(seed);
        List<String> texts =
                WorldTrees.sources().stream().filter(text -> text.length() < MAX_LENGTH).toList();
        assertThat(texts.size()).isGreaterThan(9);
        int refused = 0;
        for (int i = 0; i < MUTANTS; i++) {
            String text = texts.get(random.nextInt(texts.size()));
            for (int changes = 1 + random.nextInt(3); changes > 0; changes--) {
                text = mutated(text, random);
            }
            byte[] bytes = text.getBytes(StandardCharsets.UTF_8);
            if (random.nextInt(10) == 0 && bytes.length > 0) {
                bytes[random.nextInt(bytes.length)] ^= (byte) (1 << random.nextInt(8));
            }
            try {
                WorldFile.parse("w", bytes);
            } catch (WorldFileException invalid) {
                refused++;
                for (Problem problem : invalid.problems()) {
                    assertThat(QUOTED.matcher(problem.toString()).replaceAll(""))
                            .as("seed %d, mutant %d%n%s", seed, i, text)
                            .doesNotContainPattern(INNARDS)
                            .doesNotContainPattern("[\\p{Cc}\\p{Zl}\\p{Zp}]");
                }
            } catch (RuntimeException | Error crash) {
                fail("seed " + seed + ", mutant " + i + "\n" + text, crash);
            }
        }
        assertThat(refused).as("seed %d", seed).isGreaterThan(MUTANTS / 4);
    }

    /** Inserts a piece, replaces some characters by it, or removes some. */
    private static String mutated(String text, Random random) {
        int at = random.nextInt(text.length() + 1);
        int end = Math.min(text.length(), at + random.nextInt(8));
        String piece = PIECES.get(random.nextInt(PIECES.size()));
        return switch (random.nextInt(4)) {
            case 0 -> text.substring(0, at) + piece + text.substring(at);
            case 1 -> text.substring(0, at) + piece + text.substring(end);
            case 2 -> text.substring(0, at) + text.substring(end);
            default -> inValue(text, piece, random);
        };
    }

    /** Puts the piece in place of a value, behind a colon. */
    private static String inValue(String text, String piece, Random random) {
        int colon = text.indexOf(": ", random.nextInt(text.length() + 1));
        if (colon < 0) {
            return text + piece;
        }
        int end = colon + 2;
        while (end < text.length() && ",}]\n".indexOf(text.charAt(end)) < 0) {
            end++;
        }
        return text.substring(0, colon + 2) + piece + text.substring(end);
    }
}
