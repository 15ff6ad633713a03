// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.regex.Matcher;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/** The tests that the table of faults names exist. */
class FaultTableTest {
    private static final Path PAGE = Project.ROOT.resolve("docs/engine-process.md");
    private static final Pattern NAME =
            Pattern.compile(
                    "`(reve-pe-adapter|reve-worlds|tests|vesper-native)/(\\w+)(?:#(\\w+))?`");

    @Test
    void eachTestIsInItsRoom() throws IOException {
        String page = Files.readString(PAGE);
        String table = page.substring(page.indexOf("## Faults and their tests"));
        table = table.substring(0, table.indexOf("\n## ", 1));
        Matcher named = NAME.matcher(table);
        int found = 0;
        while (named.find()) {
            found++;
            String room = named.group(1);
            String name = named.group(2);
            if (room.equals("vesper-native")) {
                assertThat(sources(room, ".cpp"))
                        .as(named.group())
                        .anyMatch(source -> source.contains(name));
            } else {
                List<String> classes = sources(room, "/" + name + ".java");
                assertThat(classes).as(named.group()).hasSize(1);
                if (named.group(3) != null) {
                    assertThat(classes.getFirst())
                            .as(named.group())
                            .contains("void " + named.group(3) + "(");
                }
            }
        }
        assertThat(found).isGreaterThan(25);
        assertThat(table.lines().filter(line -> line.startsWith("| ")).skip(1))
                .as("each row names a test")
                .allSatisfy(row -> assertThat(row).containsPattern(NAME));
    }

    private static List<String> sources(String room, String ending) throws IOException {
        try (Stream<Path> files = Files.walk(Project.ROOT.resolve(room))) {
            return files.filter(file -> file.toString().contains("/test/"))
                    .filter(file -> file.toString().endsWith(ending))
                    .map(FaultTableTest::read)
                    .toList();
        }
    }

    private static String read(Path file) {
        try {
            return Files.readString(file);
        } catch (IOException e) {
            throw new java.io.UncheckedIOException(e);
        }
    }
}
