// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.Spec;

import reve.core.file.LawReference;
import reve.core.file.PackException;
import reve.core.file.Problem;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFileException;
import reve.core.frame.Pacing;
import reve.pe.PhysicsException;
import reve.worlds.check.WorldCheck;
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

    @Mixin private PluginOptions plugins = new PluginOptions();

    @Option(names = "--strict", description = "Refuse a world with warnings, with code 3.")
    private boolean strict;

    @Option(names = "--json", description = "Print the result as one JSON document.")
    private boolean json;

    @Override
    public Integer call() throws Exception {
        plugins.use();
        LawPath lawPath = laws.path(spec);
        List<Map<String, Object>> problems = new ArrayList<>();
        List<Map<String, Object>> warnings = new ArrayList<>();
        List<String> unchecked = new ArrayList<>();
        int code;
        try {
            code = check(lawPath.forWorld(world.folder()), problems, warnings, unchecked);
        } catch (PackException unfit) {
            if (!json) {
                throw unfit;
            }
            problems.add(Map.of("message", String.valueOf(unfit.getMessage())));
            code = ExitCode.INVALID_WORLD;
        }
        if (json) {
            Map<String, Object> result = new LinkedHashMap<>();
            result.put("world", world.shown().toString());
            result.put("valid", problems.isEmpty() && !(strict && !warnings.isEmpty()));
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
                problems.add(Warnings.fields(problem));
                if (!json) {
                    err.println(problem);
                }
            }
            return ExitCode.INVALID_WORLD;
        }
        List<LawReference> checked = new ArrayList<>();
        for (LawReference law : description.laws()) {
            if (lawPath.needsTrust(law.name())) {
                unchecked.add(law.place() + ": not checked: " + lawPath.untrusted(law.name()));
            } else {
                checked.add(law);
            }
        }
        int untrusted = unchecked.size();
        try (Simulation simulation =
                new Simulation(description.withLaws(checked), Pacing.FAST, lawPath)) {
            List<Problem> found = simulation.warnings(unchecked.isEmpty());
            warnings.addAll(Warnings.fields(found));
            boolean refused = strict && !found.isEmpty();
            if (!unchecked.isEmpty()) {
                unchecked.add(WorldCheck.leftOut());
            }
            if (!json) {
                Warnings.print(spec, found);
                unchecked.forEach(err::println);
                out.printf(
                        "%s: %s, %d items, %d laws%s%s%n",
                        world.shown(),
                        refused ? "refused by --strict" : "valid",
                        description.items().size(),
                        simulation.physics().laws().loaded().size(),
                        found.isEmpty() ? "" : ", warnings: " + found.size(),
                        untrusted == 0 ? "" : ", not checked: " + untrusted + " more");
            }
            return refused ? ExitCode.INVALID_WORLD : ExitCode.OK;
        } catch (PhysicsException refused) {
            warnings.addAll(Warnings.fields(description.warnings()));
            if (!json) {
                Warnings.print(spec, description.warnings());
            }
            refused.getMessage()
                    .lines()
                    .forEach(message -> problems.add(Map.of("message", message)));
            if (!json) {
                LinePrinter.message(err, refused.getMessage().lines().toList());
            }
            return ExitCode.PHYSICS;
        }
    }
}
