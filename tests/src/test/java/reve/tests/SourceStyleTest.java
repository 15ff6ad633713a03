package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import java.io.IOException;
import java.nio.file.FileVisitResult;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.SimpleFileVisitor;
import java.nio.file.attribute.BasicFileAttributes;
import java.util.ArrayList;
import java.util.List;
import java.util.Set;
import java.util.regex.Pattern;
import org.junit.jupiter.api.Test;

/** What every source file of the project has in common, and no compiler looks after. */
class SourceStyleTest {
    private static final int COLUMNS = 100;
    private static final Pattern SOURCE = Pattern.compile(".*\\.(java|cpp|hpp|h|c|py)");
    /** Folders of what is made from the sources. */
    private static final Set<String> MADE = Set.of("build", "__pycache__");

    @Test
    void noLineOfCodeIsLongerThan100Columns() throws IOException {
        List<Path> sources = sources();
        List<String> tooLong = new ArrayList<>();
        for (Path source : sources) {
            boolean hasTextBlocks = source.toString().endsWith(".java");
            for (int line : tooLong(Files.readAllLines(source), hasTextBlocks)) {
                tooLong.add(Project.ROOT.relativize(source) + ":" + line);
            }
        }
        assertThat(sources).contains(
                Project.ROOT.resolve("tests/src/test/java/reve/tests/SourceStyleTest.java"));
        assertThat(tooLong).as("lines of more than %d columns: break them", COLUMNS).isEmpty();
    }

    @Test
    void aLineOfATextBlockIsNoLineOfCode() {
        String x = "x".repeat(COLUMNS);
        var lines = List.of(x, x + "x", "a(\"\"\"", x + "x", "  \"\"\");", x + "x");
        assertThat(tooLong(lines, true)).containsExactly(2, 6);
        assertThat(tooLong(lines, false)).containsExactly(2, 4, 6);
    }

    /** @return numbers, from 1 on; a text block's lines are data, which breaking would change */
    private static List<Integer> tooLong(List<String> lines, boolean hasTextBlocks) {
        List<Integer> numbers = new ArrayList<>();
        boolean isText = false;
        for (int i = 0; i < lines.size(); i++) {
            String line = lines.get(i);
            if (!isText && line.codePointCount(0, line.length()) > COLUMNS) {
                numbers.add(i + 1);
            }
            boolean opensOrCloses = line.split("\"\"\"", -1).length % 2 == 0;
            isText ^= hasTextBlocks && opensOrCloses;
        }
        return numbers;
    }

    private static List<Path> sources() throws IOException {
        List<Path> sources = new ArrayList<>();
        Files.walkFileTree(Project.ROOT, new SimpleFileVisitor<>() {
            @Override
            public FileVisitResult preVisitDirectory(Path folder, BasicFileAttributes is) {
                String name = folder.getFileName().toString();
                boolean skipped = !folder.equals(Project.ROOT)
                        && (MADE.contains(name) || name.startsWith("."));
                return skipped ? FileVisitResult.SKIP_SUBTREE : FileVisitResult.CONTINUE;
            }

            @Override
            public FileVisitResult visitFile(Path file, BasicFileAttributes is) {
                if (SOURCE.matcher(file.getFileName().toString()).matches()) {
                    sources.add(file);
                }
                return FileVisitResult.CONTINUE;
            }
        });
        return sources;
    }
}
