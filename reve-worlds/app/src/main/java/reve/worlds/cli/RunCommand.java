// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.Spec;

import reve.core.file.Problem;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.worlds.journal.Journal;
import reve.worlds.journal.Recording;
import reve.worlds.journal.RecordingPlan;
import reve.worlds.server.LawPath;
import reve.worlds.server.RunReport;
import reve.worlds.server.Simulation;

import java.io.IOError;
import java.io.IOException;
import java.io.PrintWriter;
import java.nio.file.Path;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.Callable;

/** The command {@code run}: runs a world without a server and prints the report. */
@Command(
        name = "run",
        description = "Runs a world for some time, without a server, as fast as possible.")
public final class RunCommand implements Callable<Integer> {
    @Spec private CommandSpec spec = CommandSpec.create();

    @Mixin private WorldArgument world = new WorldArgument();

    @Mixin private LawOptions laws = new LawOptions();

    @Mixin private PluginOptions plugins = new PluginOptions();

    @Mixin private EngineOptions engine = new EngineOptions();

    @Option(
            names = "--seconds",
            paramLabel = "S",
            defaultValue = "5",
            description = "World time to run [s] (default: ${DEFAULT-VALUE}).")
    private double seconds;

    @Option(names = "--real-time", description = "Pace the frames to the wall clock.")
    private boolean realTime;

    @Option(
            names = "--profile",
            description = "Show how the busy time was spent, by phase and per body.")
    private boolean profile;

    @Option(
            names = "--ledger",
            description = "Show how much each law changed momentum, angular momentum and energy.")
    private boolean ledger;

    @Option(
            names = "--save",
            paramLabel = "FILE",
            description = "Write the world at the end of the run to a world file.")
    private Optional<Path> save = Optional.empty();

    @Mixin private RecordOptions record = new RecordOptions();

    @Option(names = "--json", description = "Print the result as one JSON document.")
    private boolean json;

    private volatile boolean wholeRecording = true;

    /** True if Ctrl-C or SIGTERM has ended the run before its planned end. */
    private boolean cut;

    @Override
    public Integer call() throws Exception {
        plugins.use();
        try (Interrupt interrupt = new Interrupt(spec, ExitCode.OK)) {
            boolean whole = isWhole(interrupt);
            return cut && whole ? interrupt.endsCut() : interrupt.endsWith(!whole);
        }
    }

    /**
     * Runs the world and prints the report.
     *
     * @return true if no law was quarantined and the recording is complete
     */
    private boolean isWhole(Interrupt interrupt) throws Exception {
        if (save.isPresent()) {
            save =
                    Optional.of(
                            WritableFile.require(
                                    spec, "--save", save.get(), "reve:", "a world file"));
        }
        Optional<RecordingPlan> recording = record.plan();
        world.requireLasting(spec, "--record", record.file().isPresent());
        LawPath lawPath = engine.of(laws.path(spec)).forWorld(world.folder());
        WorldDescription description = engine.of(spec, world.read());
        long frames = Frames.of(spec, "--seconds", seconds, description.timing());
        Pacing pacing = realTime ? Pacing.REAL_TIME : Pacing.FAST;
        try (Simulation simulation = new Simulation(description, pacing, lawPath)) {
            interrupt.stopWith(simulation.loop()::stop);
            List<Problem> warnings = Warnings.print(spec, simulation.warnings(true));
            simulation.usePluginListeners();
            simulation.physics().setLedger(ledger);
            // Budgets of laws apply only in real time. They would otherwise make the results of a
            // fast run depend on the speed of the machine.
            simulation.physics().enforceBudgets(realTime);
            RunReport report = recorded(simulation, frames, pacing, recording);
            cut = interrupt.wasAsked() && report.frames() < frames;
            if (cut) {
                spec.commandLine()
                        .getErr()
                        .println(
                                "reve: cut short after "
                                        + report.frames()
                                        + " of "
                                        + frames
                                        + " frames");
            }
            if (save.isPresent()) {
                WorldFile.save(save.get(), simulation.descriptionNow());
                simulation
                        .notDescribed()
                        .forEach(
                                left ->
                                        spec.commandLine()
                                                .getErr()
                                                .println(
                                                        "reve: "
                                                                + save.get()
                                                                + " does not hold "
                                                                + left));
            }
            if (json) {
                Map<String, Object> fields = fields(report, simulation);
                fields.put("warnings", Warnings.fields(warnings));
                Json.print(spec, fields);
            } else {
                print(report, simulation);
            }
            return report.faults().isEmpty() && wholeRecording;
        }
    }

    private Map<String, Object> fields(RunReport report, Simulation simulation) {
        Map<String, Object> fields = report.fields();
        if (ledger) {
            fields.put("ledger", new LedgerReport(simulation.physics().ledger()).fields());
        }
        return fields;
    }

    private void print(RunReport report, Simulation simulation) {
        PrintWriter out = spec.commandLine().getOut();
        report.print(out);
        if (profile) {
            report.printProfile(out);
        }
        if (ledger) {
            new LedgerReport(simulation.physics().ledger()).print(out);
        }
        out.flush();
    }

    private RunReport recorded(
            Simulation simulation, long frames, Pacing pacing, Optional<RecordingPlan> plan)
            throws IOException {
        if (plan.isEmpty()) {
            return run(simulation, frames);
        }
        Recording recording = new Recording(plan.get());
        recording
                .older()
                .ifPresent(
                        older ->
                                spec.commandLine()
                                        .getErr()
                                        .println(
                                                "reve: the "
                                                        + "recording that was in "
                                                        + plan.get().file()
                                                        + " is now "
                                                        + older));
        try (Journal _ =
                simulation.journal(
                        world.folder(),
                        Map.of(),
                        new Journal.Plan(0, pacing == Pacing.FAST),
                        recording,
                        this::tellRecording)) {
            return run(simulation, frames);
        } catch (IOError ended) {
            throw new IOException(ended.getCause().getMessage(), ended);
        }
    }

    /** Reports a problem of the recording. Called on any thread. */
    private void tellRecording(String problem) {
        wholeRecording = false;
        spec.commandLine().getErr().println("reve: recording: " + problem);
    }

    private static RunReport run(Simulation simulation, long frames) {
        Progress progress = new Progress(System.err, frames);
        simulation.onPublish("progress", event -> progress.at(event.frame(), event.timeSeconds()));
        long start = System.nanoTime();
        simulation.loop().run(frames);
        double wallSeconds = (System.nanoTime() - start) * 1e-9;
        progress.done();
        return RunReport.of(simulation, wallSeconds);
    }
}
