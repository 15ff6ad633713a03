// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import java.io.IOException;
import java.io.UncheckedIOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/**
 * The dependencies of ARCHITECTURE.md below the engine. One folder is one law, which uses the SDK.
 */
class LawFoldersTest {
    private static final Path LAWS = Project.ROOT.resolve("laws");
    private static final Path SUPPORT = Project.ROOT.resolve("law-support");
    private static final Pattern INCLUDE = Pattern.compile("#include [<\"](vesper/[^>\"]+)");
    private static final String SDK = "vesper/(types|units|law)\\.h|vesper/law\\w*\\.hpp";

    @Test
    void eachFolderIsOneLawWithItsReadme() throws IOException {
        List<Path> folders = list(LAWS).filter(Files::isDirectory).toList();
        assertThat(folders).isNotEmpty();
        for (Path folder : folders) {
            String law = folder.getFileName().toString();
            assertThat(folder.resolve("README.md")).exists();
            assertThat(Files.readString(folder.resolve("CMakeLists.txt")))
                    .containsOnlyOnce("_law(" + law);
        }
        List<String> shipped =
                list(Project.NATIVE.resolve("laws"))
                        .filter(file -> file.toString().endsWith(".so"))
                        .map(LawFoldersTest::lawOf)
                        .toList();
        assertThat(shipped)
                .containsExactlyInAnyOrderElementsOf(
                        folders.stream().map(folder -> folder.getFileName().toString()).toList());
    }

    @Test
    void lawsAndWhatTheyShareIncludeOfVesperTheSdkOnly() throws IOException {
        List<Path> sources = Stream.of(LAWS, SUPPORT).flatMap(LawFoldersTest::sources).toList();
        assertThat(sources).isNotEmpty();
        for (Path source : sources) {
            assertThat(INCLUDE.matcher(Files.readString(source)).results())
                    .as(source.toString())
                    .allSatisfy(include -> assertThat(include.group(1)).matches(SDK));
        }
    }

    /** The sources of libraries, without tests and their scenes. */
    private static Stream<Path> sources(Path folder) {
        try (Stream<Path> files = Files.walk(folder)) {
            return files
                    .filter(path -> path.toString().matches(".*\\.[ch](pp)?"))
                    .filter(path -> !path.startsWith(SUPPORT.resolve("testing")))
                    .filter(path -> !path.toString().matches(".*_(test\\.cpp|scene\\.hpp)"))
                    .toList()
                    .stream();
        } catch (IOException e) {
            throw new UncheckedIOException(e);
        }
    }

    private static Stream<Path> list(Path folder) throws IOException {
        try (Stream<Path> paths = Files.list(folder)) {
            return paths.toList().stream();
        }
    }

    private static String lawOf(Path library) {
        return library.getFileName().toString().replaceAll("libvesper_law_|\\.so", "");
    }
}
