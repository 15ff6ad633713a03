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
 * A world file with all files that it includes directly or through other files, after the schema
 * check. Each file is read once.
 *
 * @param world the outermost mapping of the world file
 * @param parts the outermost mappings of all files; an included file precedes the including one
 * @param files resolves the files that the world names
 * @param seed seed of an experiment's run, on which random numbers of formulas depend; 0 for the
 *     world as its file describes it
 */
record WorldSource(Node world, List<Node> parts, SourceFiles files, long seed) {
    /** Maximum depth of inclusion. */
    static final int MAX_DEPTH = 16;

    /** Maximum seed. */
    static final long MAX_SEED = Integer.MAX_VALUE;

    private static final int SEED_SHIFT = 32;

    WorldSource(Node world, List<Node> parts, SourceFiles files) {
        this(world, parts, files, 0);
    }

    /**
     * Returns the index that the random generator gets for the first repetition. Each further
     * repetition adds 1 to the index. There are fewer than 2^32 repetitions, so the indices of
     * different seeds do not overlap.
     */
    long firstNumber() {
        return seed << SEED_SHIFT;
    }

    /**
     * Reads a world file and its included files.
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

    /** Reads a world that is not in a file, and can therefore not include files. */
    static WorldSource parse(byte[] content, Problems problems) throws WorldFileException {
        var reader = new Reader(WorldFolder.none(), problems);
        return reader.read(reader.files.decode(content, problems));
    }

    /** Returns the values of a top-level key in all files that have the key. */
    List<Node> each(String key) {
        return parts.stream().map(part -> part.get(key)).flatMap(Optional::stream).toList();
    }

    /** Returns the elements of the values under a top-level key, in all files. */
    List<Node> all(String key) {
        return each(key).stream().flatMap(node -> node.children().stream()).toList();
    }

    /** Returns the values of the mappings under a top-level key, in all files. */
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

        /**
         * Real paths of the files that are being read. Each file is included by the file before it.
         * Used to find cycles.
         */
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
