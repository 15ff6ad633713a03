// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.disk.Reason;
import reve.core.file.LawReference;
import reve.core.file.ParameterFile;
import reve.core.file.WorldFileException;
import reve.core.text.Visible;
import reve.core.unit.Unit;
import reve.pe.LawParameter;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.SiUnit;
import reve.pe.Status;
import reve.pe.adapter.FolderParameters;
import reve.pe.posix.RegularFile;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** Finds wrong parameters of a law and their places in the world file. */
final class LawParameters {
    /** Maximum size of a file with parameters [bytes]. */
    private static final int MOST_BYTES = 64 * 1024;

    private LawParameters() {}

    /**
     * Returns the parameters whose unit has another dimension than the law requires. The result
     * maps the name of each such parameter to a message with its place in the file.
     *
     * @param loaded the laws of the library
     */
    static Map<String, String> wrongUnits(LawReference law, List<PhysicsLaw> loaded) {
        Map<String, String> wrong = new LinkedHashMap<>();
        law.mentions()
                .forEach(
                        (name, mention) -> {
                            Optional<SiUnit> asked =
                                    loaded.stream()
                                            .flatMap(
                                                    each ->
                                                            each.parameters().stream()
                                                                    .filter(
                                                                            parameter ->
                                                                                    isNamed(
                                                                                            parameter,
                                                                                            each,
                                                                                            name)))
                                            .findFirst()
                                            .map(LawParameter::unit);
                            if (asked.isPresent()
                                    && mention.unit().isPresent()
                                    && !sameDimension(mention.unit().get(), asked.get())) {
                                wrong.put(
                                        name,
                                        Visible.line(mention.place())
                                                + ": law "
                                                + law.name()
                                                + ": parameter "
                                                + name
                                                + ": unit "
                                                + mention.unit().get()
                                                + " does not fit "
                                                + asked.get().symbol());
                            }
                        });
        return wrong;
    }

    /**
     * Returns why a law was refused: messages with the places of the wrong parameters, or with the
     * law's place.
     */
    static List<String> refused(
            LawReference law, PhysicsException refused, PhysicsEngine engine, LawPath lawPath) {
        List<String> wrong = new ArrayList<>();
        if (!law.mentions().isEmpty()) {
            try {
                Map<String, String> units = load(law, Map.of(), engine, lawPath);
                law.mentions()
                        .forEach(
                                (name, mention) -> {
                                    if (units.containsKey(name)) {
                                        wrong.add(units.get(name));
                                    } else {
                                        refusal(law, name, engine, lawPath)
                                                .ifPresent(
                                                        message ->
                                                                wrong.add(
                                                                        Visible.line(
                                                                                        mention
                                                                                                .place())
                                                                                + ": "
                                                                                + message));
                                    }
                                });
            } catch (PhysicsException notForItsParameters) {
                // The engine accepts each parameter alone, so it refuses the law for another
                // reason. Therefore the message names the place of the law instead of a parameter.
            }
        }
        if (wrong.isEmpty()) {
            wrong.add(Visible.line(law.place()) + ": " + refused.getMessage());
        }
        return wrong;
    }

    /**
     * Returns the engine's refusal of the law with only this parameter; empty if the engine accepts
     * it.
     */
    private static Optional<String> refusal(
            LawReference law, String name, PhysicsEngine engine, LawPath lawPath) {
        try {
            load(law, Map.of(name, law.parameters().get(name)), engine, lawPath);
            return Optional.empty();
        } catch (PhysicsException refused) {
            return Optional.of(refused.getMessage());
        }
    }

    /** Loads and unloads the law, and returns messages about units that do not fit. */
    private static Map<String, String> load(
            LawReference law,
            Map<String, Double> parameters,
            PhysicsEngine engine,
            LawPath lawPath) {
        try (PreparedLibrary prepared =
                lawPath.prepare(engine, law.name(), lawPath.find(law.name()))) {
            int id = engine.loadPhysicsLaw(prepared, parameters);
            Map<String, String> wrong = wrongUnits(law, engine.laws(id));
            engine.unloadPhysicsLaw(id);
            return wrong;
        }
    }

    /**
     * Reads the file with the parameters of a library in a watched folder. Other programs may
     * replace the file at any time.
     *
     * @throws PhysicsException with the places of all mistakes
     */
    static FolderParameters inFile(String library, Path file) {
        try {
            String text =
                    StandardCharsets.UTF_8
                            .newDecoder()
                            .decode(ByteBuffer.wrap(RegularFile.read(file, MOST_BYTES)))
                            .toString();
            LawReference read = ParameterFile.read(library, text, file.toString());
            return new FolderParameters(
                    read.parameters(),
                    laws -> {
                        Map<String, String> wrong = wrongUnits(read, laws);
                        if (!wrong.isEmpty()) {
                            throw new PhysicsException(
                                    Status.INVALID_ARGUMENT, String.join("\n", wrong.values()));
                        }
                    });
        } catch (WorldFileException mistakes) {
            throw new PhysicsException(Status.INVALID_ARGUMENT, mistakes.getMessage());
        } catch (IOException unreadable) {
            throw new PhysicsException(
                    Status.INVALID_ARGUMENT, file + ": " + Reason.of(unreadable));
        }
    }

    private static boolean isNamed(LawParameter parameter, PhysicsLaw law, String name) {
        return name.equals(parameter.name()) || name.equals(law.name() + "." + parameter.name());
    }

    private static boolean sameDimension(Unit given, SiUnit asked) {
        return Arrays.equals(given.exponents(), asked.exponents());
    }
}
