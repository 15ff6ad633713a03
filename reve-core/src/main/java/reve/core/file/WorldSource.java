// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.mesh.WorldFolder;

import java.io.IOException;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.HashSet;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Optional;
import java.util.Set;

/**
 * A world file with the files that it includes, directly or not, each once, their form checked.
 *
 * @param world the outermost mapping of the world file
 * @param parts those of all files; what is included comes before what includes it
 * @param files where files that the world names are found
 */
record WorldSource(Node world, List<Node> parts, SourceFiles files) {
    /** Most files of which each is included by the one before. */
    static final int MAX_DEPTH = 16;

    /**
     * Reads a world file and what it includes.
     *
     * @throws IOException if the system cannot read the world file
     */
    static WorldSource read(Path path, WorldFolder folder, Problems problems)
            throws WorldFileException, IOException {
        var reader = new Reader(folder, problems);
        String text = reader.files.read(path, problems);
        reader.open.add(path.toRealPath());
        return reader.read(text);
    }

    /** Reads a world that is in no file, and can therefore include none. */
    static WorldSource parse(byte[] content, Problems problems) throws WorldFileException {
        var reader = new Reader(WorldFolder.none(), problems);
        return reader.read(reader.files.decode(content, problems));
    }

    /** What a key has under it in each file that has it. */
    List<Node> each(String key) {
        return parts.stream().map(part -> part.get(key)).flatMap(Optional::stream).toList();
    }

    /** What a key holds, in all files together. */
    List<Node> all(String key) {
        return each(key).stream().flatMap(node -> node.children().stream()).toList();
    }

    /** What a key holds by name, in all files together. */
    List<Node> named(String key) {
        return each(key).stream()
                .filter(Node::isMapping)
                .flatMap(node -> node.children().stream())
                .toList();
    }

    private static final class Reader {
        private final SourceFiles files;
        private final Problems problems;
        private final Allowance values = new Allowance(YamlReader.MAX_VALUES);
        private final List<Node> parts = new ArrayList<>();

        /** Real paths of files that are being read, the innermost last, and that were read. */
        private final Set<Path> open = new LinkedHashSet<>();

        private final Set<Path> done = new HashSet<>();

        Reader(WorldFolder folder, Problems problems) {
            this.files = new SourceFiles(folder, problems.file());
            this.problems = problems;
        }

        WorldSource read(String text) throws WorldFileException {
            Node world = YamlReader.read(text, problems, values);
            SchemaCheck.check(world, problems);
            includeAll(world);
            parts.add(world);
            return new WorldSource(world, List.copyOf(parts), files);
        }

        private void includeAll(Node part) throws WorldFileException {
            for (Node name : part.get("include").map(Node::children).orElse(List.of())) {
                if (problems.full()) {
                    return;
                }
                Optional<SourceFiles.Source> found = files.find(name, problems);
                if (found.isPresent()) {
                    include(name, found.get());
                }
            }
        }

        private void include(Node name, SourceFiles.Source source) throws WorldFileException {
            if (open.contains(source.path())) {
                problems.add(
                        name,
                        name.label()
                                + ": "
                                + source.name()
                                + " is being read already: files include each other in a circle");
            } else if (open.size() > MAX_DEPTH) {
                problems.add(
                        name,
                        name.label()
                                + ": more than "
                                + MAX_DEPTH
                                + " files of which each is included by the one before");
            } else if (done.add(source.path())) {
                open.add(source.path());
                readPart(source);
                open.remove(source.path());
            }
        }

        private void readPart(SourceFiles.Source source) throws WorldFileException {
            Problems told = problems.of(source.name());
            Node part = YamlReader.read(files.read(source, told), told, values);
            SchemaCheck.checkPart(part, told);
            includeAll(part);
            parts.add(part);
        }
    }
}
