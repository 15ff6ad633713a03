// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.List;
import java.util.Optional;

/**
 * The number of an item's repetitions, and the variables that its formulas use.
 *
 * @param variables names of the variables
 * @param count number of repetitions
 * @param values values of the variables, for each repetition
 */
record Repetition(List<String> variables, long count, Values values) {
    private static final String INDEX = "i";

    /** A function that returns the values of the variables in one repetition. */
    interface Values {
        double[] at(long number);
    }

    /**
     * Reads the value of the key {@code repeat}. Records a problem and returns empty if the value
     * is wrong.
     */
    static Optional<Repetition> read(Node node, SourceFiles files, Problems problems)
            throws WorldFileException {
        if (node.text().isPresent()) {
            Optional<SourceFiles.Source> file = files.find(node, problems);
            return file.isEmpty()
                    ? Optional.empty()
                    : Optional.of(CsvTable.read(file.get(), files, problems));
        }
        if (node.number().isPresent()) {
            long count = node.number().get().longValue();
            return Optional.of(
                    new Repetition(List.of(INDEX), count, number -> new double[] {number}));
        }
        return node.isMapping() ? grid(node, problems) : Optional.empty();
    }

    /**
     * Reads a grid, which has one repetition for each combination of several indices. The last
     * index changes fastest.
     */
    private static Optional<Repetition> grid(Node node, Problems problems) {
        List<String> names = node.children().stream().map(Node::key).toList();
        for (Node index : node.children()) {
            if (Formula.isTaken(index.key())) {
                problems.addAtKey(
                        index,
                        "`"
                                + index.key()
                                + "` means something else in formulas; "
                                + "choose another name");
                return Optional.empty();
            }
        }
        long[] counts =
                node.children().stream()
                        .mapToLong(index -> index.number().orElse(0.0).longValue())
                        .toArray();
        double count = 1;
        for (long each : counts) {
            count *= each;
        }
        return Optional.of(
                new Repetition(
                        names,
                        (long) count,
                        number -> {
                            double[] values = new double[counts.length];
                            long rest = number;
                            for (int i = counts.length - 1; i >= 0; i--) {
                                values[i] = rest % counts[i];
                                rest /= counts[i];
                            }
                            return values;
                        }));
    }
}
