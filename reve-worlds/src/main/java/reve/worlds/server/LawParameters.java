// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.file.LawReference;
import reve.core.unit.Unit;
import reve.pe.LawParameter;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.SiUnit;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** Finds which parameters of a law are wrong, and where the world file says them. */
final class LawParameters {
    private LawParameters() {}

    /**
     * Parameters in units that measure something else than the law asks for: a line with its place
     * for each, by name.
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
                                        mention.place()
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

    /** What a law was refused for: lines with the places of wrong parameters, or of the law. */
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
                                                                        mention.place()
                                                                                + ": "
                                                                                + message));
                                    }
                                });
            } catch (PhysicsException notForItsParameters) {
                // then it is the law that is wrong
            }
        }
        if (wrong.isEmpty()) {
            wrong.add(law.place() + ": " + refused.getMessage());
        }
        return wrong;
    }

    /** What the engine has against one parameter by itself. */
    private static Optional<String> refusal(
            LawReference law, String name, PhysicsEngine engine, LawPath lawPath) {
        try {
            load(law, Map.of(name, law.parameters().get(name)), engine, lawPath);
            return Optional.empty();
        } catch (PhysicsException refused) {
            return Optional.of(refused.getMessage());
        }
    }

    /** Loads and unloads the law, and says which units do not fit it. */
    private static Map<String, String> load(
            LawReference law,
            Map<String, Double> parameters,
            PhysicsEngine engine,
            LawPath lawPath) {
        try (PreparedLibrary prepared =
                lawPath.prepare(engine, law.name(), lawPath.find(law.name()))) {
            int id = engine.loadPhysicsLaw(prepared, parameters);
            Map<String, String> wrong = wrongUnits(law, lawsOf(id, engine));
            engine.unloadPhysicsLaw(id);
            return wrong;
        }
    }

    /** The laws of a loaded library. */
    static List<PhysicsLaw> lawsOf(int libraryId, PhysicsEngine engine) {
        return engine.laws().stream().filter(law -> law.libraryId() == libraryId).toList();
    }

    private static boolean isNamed(LawParameter parameter, PhysicsLaw law, String name) {
        return name.equals(parameter.name()) || name.equals(law.name() + "." + parameter.name());
    }

    private static boolean sameDimension(Unit given, SiUnit asked) {
        return Arrays.equals(given.exponents(), asked.exponents());
    }
}
