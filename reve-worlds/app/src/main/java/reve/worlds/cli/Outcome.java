// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;

import reve.core.file.Problem;
import reve.core.world.WorldEvent;
import reve.worlds.server.RunReport;
import reve.worlds.server.Simulation;

import java.io.PrintWriter;
import java.util.List;
import java.util.Map;

/**
 * The warnings and the faults of a world that a command runs for another purpose than its report,
 * for example for a picture.
 */
final class Outcome {
    private final CommandSpec spec;
    private final Simulation simulation;
    private final List<Problem> warnings;

    /** Prints the warnings of the check to standard error. Called before the first frame. */
    Outcome(CommandSpec spec, Simulation simulation) {
        this.spec = spec;
        this.simulation = simulation;
        this.warnings = Warnings.print(spec, simulation.warnings(true));
    }

    /** Adds the warnings and the faults to the fields for JSON. Called between frames. */
    void addTo(Map<String, Object> fields) {
        fields.put(
                "faults", simulation.events().faults().stream().map(WorldEvent::fields).toList());
        fields.put("warnings", Warnings.fields(warnings));
    }

    /**
     * Prints the faults to standard error, and returns the exit code. Called after the last frame.
     */
    int code() {
        PrintWriter err = spec.commandLine().getErr();
        List<WorldEvent> faults = simulation.events().faults();
        faults.forEach(fault -> err.println("reve: " + RunReport.line(fault)));
        err.flush();
        return faults.isEmpty() ? ExitCode.OK : ExitCode.FAILURE;
    }
}
