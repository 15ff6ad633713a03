// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.WorldPrototype;

import java.util.Arrays;
import java.util.Collection;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/**
 * Reader of a file that contains only the parameters of one law. The file is a mapping in YAML,
 * with values as under the key {@code parameters} of a world file, such as {@code drag: 3 kg/s}.
 * For any thread.
 */
public final class ParameterFile {

    private ParameterFile() {}

    /**
     * Reads the parameters of a law and converts them to SI units. Does not check their names and
     * dimensions, because only the loaded law knows them.
     *
     * @param law name of the law
     * @param file name of the file, for positions in messages
     * @throws WorldFileException with all problems of the text
     */
    public static LawReference read(String law, String text, String file)
            throws WorldFileException {
        var problems = new Problems(file);
        Node root = YamlReader.read(text, problems, new Allowance(YamlReader.MAX_VALUES));
        var physics =
                new PhysicsReader(
                        WorldPrototype.standard("si-f64"), Set.of(), Doubts.REFUSED, problems);
        for (Node value : root.children()) {
            if (value.text().isEmpty() && value.number().isEmpty() && !value.isList()) {
                problems.add(
                        value, value.label() + ": expected a number with a unit, such as `3 kg/s`");
            }
        }
        problems.throwIfAny();
        LawReference read =
                reference(
                        law,
                        Optional.empty(),
                        root.children(),
                        file,
                        new Quantities(problems),
                        physics,
                        problems);
        problems.throwIfAny();
        return read;
    }

    /** Returns a law with the parameters of these nodes. Records the problems of their values. */
    static LawReference reference(
            String name,
            Optional<String> text,
            Collection<Node> parameters,
            String place,
            Quantities quantities,
            PhysicsReader physics,
            Problems problems) {
        Map<String, Double> values = new LinkedHashMap<>();
        Map<String, LawReference.Mention> mentions = new LinkedHashMap<>();
        for (Node node : parameters) {
            if (problems.full()) {
                break;
            }
            Optional<Quantities.NumberOrVector> read = quantities.numberOrVector(node);
            if (read.isEmpty()) {
                continue;
            }
            double[] numbers = read.get().values();
            if (!Arrays.stream(numbers).allMatch(value -> physics.isWorkable(node, value))) {
                continue;
            }
            List<String> names = LawReference.parameterNames(node.key(), numbers.length);
            for (int i = 0; i < numbers.length; i++) {
                values.put(names.get(i), numbers[i]);
                mentions.put(
                        names.get(i),
                        new LawReference.Mention(Problems.keyPlace(node), read.get().unit()));
            }
        }
        return new LawReference(name, text, values, Optional.empty(), place, mentions);
    }
}
