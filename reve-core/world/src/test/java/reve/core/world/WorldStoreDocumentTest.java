// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import java.io.ByteArrayOutputStream;
import java.io.PrintStream;
import java.net.URL;
import java.net.URLClassLoader;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.Objects;
import java.util.regex.MatchResult;
import java.util.regex.Pattern;

import javax.tools.ToolProvider;

/** {@code docs/world-store.md}: the test compiles and runs all of its code together. */
class WorldStoreDocumentTest {

    private static final String PROGRAM =
            """
            import java.util.*;
            import reve.core.derive.*;
            import reve.core.frame.*;
            import reve.core.space.*;
            import reve.core.world.*;

            public class Program {
                static List<String> names(World world, List<ItemId> ids) {
                    return ids.stream().map(id -> world.item(id).name()).toList();
                }

                public static void main(String[] arguments) {
            %s
                }
            }
            """;

    @TempDir private Path folder;

    private static String blocks(String language) throws Exception {
        Path page =
                Path.of(Objects.requireNonNull(System.getProperty("reve.root")))
                        .resolve("docs/world-store.md");
        List<String> blocks =
                Pattern.compile("```" + language + "\n(.*?)```", Pattern.DOTALL)
                        .matcher(Files.readString(page))
                        .results()
                        .map((MatchResult match) -> match.group(1))
                        .toList();
        return String.join("", blocks);
    }

    @Test
    void itsCodePrintsWhatItSays() throws Exception {
        Path source = folder.resolve("Program.java");
        Files.writeString(source, PROGRAM.formatted(blocks("java")));
        var problems = new ByteArrayOutputStream();
        int status =
                ToolProvider.getSystemJavaCompiler()
                        .run(
                                null,
                                null,
                                problems,
                                "-d",
                                folder.toString(),
                                "-cp",
                                System.getProperty("java.class.path"),
                                source.toString());
        assertThat(status).as(problems.toString(StandardCharsets.UTF_8)).isZero();

        var printed = new ByteArrayOutputStream();
        PrintStream out = System.out;
        try (var loader = new URLClassLoader(new URL[] {folder.toUri().toURL()})) {
            System.setOut(new PrintStream(printed, true, StandardCharsets.UTF_8));
            loader.loadClass("Program")
                    .getMethod("main", String[].class)
                    .invoke(null, (Object) new String[0]);
        } finally {
            System.setOut(out);
        }
        assertThat(printed.toString(StandardCharsets.UTF_8)).isEqualTo(blocks("text"));
    }
}
