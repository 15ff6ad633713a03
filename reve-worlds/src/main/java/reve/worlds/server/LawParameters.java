package reve.worlds.server;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.function.Function;
import reve.core.file.LawReference;
import reve.core.unit.Unit;
import reve.pe.LawParameter;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.SiUnit;

/** Finds which parameters of a law are wrong, and where the world file says them. */
final class LawParameters {
    private LawParameters() {}

    /**
     * Parameters in units that measure something else than the law asks for: a line with its place
     * for each.
     *
     * @param loaded the laws of the library
     */
    static List<String> wrongUnits(LawReference law, List<PhysicsLaw> loaded) {
        List<String> wrong = new ArrayList<>();
        law.mentions().forEach((name, mention) -> {
            Optional<SiUnit> asked = loaded.stream().flatMap(each -> each.parameters().stream()
                    .filter(parameter -> isNamed(parameter, each, name))).findFirst()
                    .map(LawParameter::unit);
            if (asked.isPresent() && mention.unit().isPresent()
                    && !sameDimension(mention.unit().get(), asked.get())) {
                wrong.add(mention.place() + ": law " + law.name() + ": parameter " + name
                        + ": unit " + mention.unit().get() + " does not fit "
                        + asked.get().symbol());
            }
        });
        return wrong;
    }

    /** What a law was refused for: lines with the places of wrong parameters, or of the law. */
    static List<String> refused(LawReference law, PhysicsException refused, PhysicsEngine engine,
            LawPath lawPath) {
        List<String> wrong = new ArrayList<>();
        Function<Map<String, Double>, Optional<String>> refusal =
                parameters -> refusal(law.name(), parameters, engine, lawPath);
        if (!law.mentions().isEmpty() && refusal.apply(Map.of()).isEmpty()) {
            law.mentions().forEach((name, mention) ->
                    refusal.apply(Map.of(name, law.parameters().get(name)))
                            .ifPresent(message -> wrong.add(mention.place() + ": " + message)));
        }
        if (wrong.isEmpty()) {
            wrong.add(law.place() + ": " + refused.getMessage());
        }
        return wrong;
    }

    /** What the engine has against the law with these parameters. */
    private static Optional<String> refusal(String law, Map<String, Double> parameters,
            PhysicsEngine engine, LawPath lawPath) {
        try (PreparedLibrary prepared = lawPath.prepare(engine, law, lawPath.find(law))) {
            engine.unloadPhysicsLaw(engine.loadPhysicsLaw(prepared, parameters));
            return Optional.empty();
        } catch (PhysicsException refused) {
            return Optional.of(refused.getMessage());
        }
    }

    private static boolean isNamed(LawParameter parameter, PhysicsLaw law, String name) {
        return name.equals(parameter.name()) || name.equals(law.name() + "." + parameter.name());
    }

    private static boolean sameDimension(Unit given, SiUnit asked) {
        return Arrays.equals(given.exponents(), asked.exponents());
    }
}
