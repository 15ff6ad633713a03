// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.ConcurrentHashMap;
import java.util.stream.Collectors;

/** Reads the equations of laws from the section "Equation" of each law's README. For any thread. */
final class LawEquations {
    private static final String SECTION = "## Equation";
    private static final String NEXT = "## ";
    private static final String INDENT = "    ";
    private static final long MAX_BYTES = 1 << 18;

    private final Optional<Path> folder =
            Optional.ofNullable(System.getProperty("reve.root")).map(root -> Path.of(root, "laws"));
    private final Map<String, Optional<String>> known = new ConcurrentHashMap<>();

    /** Reads the equations of these laws, unless they were read before. Blocks on file access. */
    void read(List<String> laws) {
        folder.ifPresent(
                place -> laws.forEach(law -> known.computeIfAbsent(law, name -> in(place, name))));
    }

    /** Returns the equation of a law, if it was read. */
    Optional<String> of(String law) {
        return known.getOrDefault(law, Optional.empty());
    }

    private static Optional<String> in(Path laws, String law) {
        Path readme = laws.resolve(law).resolve("README.md");
        try {
            if (!Files.isRegularFile(readme) || Files.size(readme) > MAX_BYTES) {
                return Optional.empty();
            }
            String equation =
                    Files.readAllLines(readme).stream()
                            .dropWhile(line -> !line.equals(SECTION))
                            .skip(1)
                            .takeWhile(line -> !line.startsWith(NEXT))
                            .filter(line -> line.startsWith(INDENT))
                            .map(line -> line.substring(INDENT.length()))
                            .collect(Collectors.joining("\n"));
            return equation.isBlank() ? Optional.empty() : Optional.of(equation);
        } catch (IOException unreadable) {
            return Optional.empty(); // a law without a readable README has no equation to show
        }
    }
}
