// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Map;
import java.util.TreeMap;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/** Follows docs/learned-laws.md. A network learns a hidden law and acts as a law. */
@Tag("slow")
class LearnedLawIT {
    /** Maximum distance of a stone from its place under the hidden law, during 10 s [m]. */
    private static final double BOUND = 0.01;

    private static final Pattern LINE =
            Pattern.compile("(stone-\\d): \\S+ m at the end, (\\S+) m at most, on (\\d+) m");

    @TempDir private Path folder;

    /** Returns the largest divergence of each stone [m]. */
    private static Map<String, Double> divergences(String output) {
        Map<String, Double> found = new TreeMap<>();
        Matcher line = LINE.matcher(output);
        while (line.find()) {
            found.put(line.group(1), Double.parseDouble(line.group(2)));
            assertThat(Double.parseDouble(line.group(3))).as("path of a stone").isGreaterThan(5);
        }
        return found;
    }

    @Test
    void stonesMoveUnderTheLearnedLawAsUnderTheHiddenOne() throws Exception {
        Document page = Document.read(Project.ROOT.resolve("docs/learned-laws.md"));
        Shell shell = new Shell(folder);
        for (String file :
                new String[] {"hidden.law", "valley.yaml", "learn.py", "divergence.py"}) {
            Files.writeString(folder.resolve(file), page.titled(file).text());
        }
        shell.run(page.titled("record.sh").text());
        assertThat(shell.run(page.titled("learn.sh").text()))
                .contains("25 weights", "PASS  angular-momentum", "PASS  rotation", " 0 failed, ");
        String compare = page.titled("compare.sh").text();
        assertThat(divergences(shell.run(compare)))
                .hasSize(8)
                .allSatisfy((stone, most) -> assertThat(most).as(stone).isLessThan(BOUND));

        // The places of the stones show that the training was shorter.
        String learn = page.titled("learn.py").text();
        assertThat(learn).contains("400, 400\n");
        Files.writeString(folder.resolve("learn.py"), learn.replace("400, 400\n", "400, 5\n"));
        shell.run("/usr/bin/python3 learn.py hidden/body.csv laws/learned.py");
        assertThat(divergences(shell.run(compare)).values()).anyMatch(most -> most > 10 * BOUND);
    }
}
