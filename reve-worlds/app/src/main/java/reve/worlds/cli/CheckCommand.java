// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.Spec;

import reve.core.file.LawReference;
import reve.core.file.Problem;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFileException;
import reve.core.frame.Pacing;
import reve.pe.PhysicsException;
import reve.worlds.server.LawPath;
import reve.worlds.server.Simulation;

import java.io.PrintWriter;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.concurrent.Callable;

/**
 * The command {@code check}: reads a world file, builds the world, loads its laws, and runs no
 * frame.
 */
@Command(
        name = "check",
        description = "Checks a world file and loads its laws, without running the world.")
public final class CheckCommand implements Callable<Integer> {
    @Spec private CommandSpec spec = CommandSpec.create();

    @Mixin private WorldArgument world = new WorldArgument();

    @Mixin private LawOptions laws = new LawOptions();

    @Option(names = "--json", description = "Print the result as one JSON document.")
    private boolean json;

    @Override
    public Integer call() throws Exception {
        LawPath lawPath = laws.path(spec).forWorld(world.folder());
        List<Map<String, Object>> problems = new ArrayList<>();
        List<Map<String, Object>> warnings = new ArrayList<>();
        List<String> unchecked = new ArrayList<>();
        int code = check(lawPath, problems, warnings, unchecked);
        if (json) {
            Map<String, Object> result = new LinkedHashMap<>();
            result.put("world", world.file().toString());
            result.put("valid", problems.isEmpty());
            result.put("problems", problems);
            result.put("warnings", warnings);
            result.put("unchecked", unchecked);
            Json.print(spec, result);
        }
        return code;
    }

    private int check(
            LawPath lawPath,
            List<Map<String, Object>> problems,
            List<Map<String, Object>> warnings,
            List<String> unchecked)
            throws Exception {
        PrintWriter out = spec.commandLine().getOut();
        PrintWriter err = spec.commandLine().getErr();
        WorldDescription description;
        try {
            description = world.read();
        } catch (WorldFileException invalid) {
            for (Problem problem : invalid.problems()) {
                problems.add(fields(problem));
                if (!json) {
                    err.println(problem);
                }
            }
            return ExitCode.INVALID_WORLD;
        }
        for (Problem warning : description.warnings()) {
            warnings.add(fields(warning));
            if (!json) {
                err.println(warning);
            }
        }
        List<LawReference> checked = new ArrayList<>();
        for (LawReference law : description.laws()) {
            if (lawPath.needsTrust(law.name())) {
                unchecked.add(law.place() + ": not checked: " + LawPath.untrusted(law.name()));
            } else {
                checked.add(law);
            }
        }
        try (Simulation simulation =
                new Simulation(description.withLaws(checked), Pacing.FAST, lawPath)) {
            if (!json) {
                unchecked.forEach(err::println);
                out.printf(
                        "%s: valid, %d items, %d laws%s%n",
                        world.file(),
                        description.items().size(),
                        simulation.physics().laws().loaded().size(),
                        unchecked.isEmpty() ? "" : ", not checked: " + unchecked.size() + " more");
            }
            return ExitCode.OK;
        } catch (PhysicsException refused) {
            refused.getMessage()
                    .lines()
                    .forEach(message -> problems.add(Map.of("message", message)));
            if (!json) {
                LinePrinter.message(err, refused.getMessage());
            }
            return ExitCode.PHYSICS;
        }
    }

    private static Map<String, Object> fields(Problem problem) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("file", problem.file());
        fields.put("line", problem.line());
        fields.put("column", problem.column());
        fields.put("pointer", problem.pointer());
        fields.put("message", problem.message());
        return fields;
    }
}
