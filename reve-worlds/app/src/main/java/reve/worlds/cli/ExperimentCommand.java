// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;
import picocli.CommandLine.Spec;

import reve.core.file.Experiment;
import reve.core.file.Problem;
import reve.core.file.WorldFileException;
import reve.core.text.Rounded;
import reve.worlds.experiment.Difference;
import reve.worlds.experiment.ExperimentRuns;
import reve.worlds.experiment.ResultFolder;
import reve.worlds.experiment.RunJournal;
import reve.worlds.experiment.RunProgress;
import reve.worlds.experiment.RunResult;
import reve.worlds.server.LawPath;

import java.io.IOException;
import java.io.PrintWriter;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.TreeSet;
import java.util.concurrent.Callable;
import java.util.concurrent.ConcurrentSkipListSet;

/**
 * The command {@code experiment}: runs an experiment file and compares the results with earlier
 * results.
 */
@Command(
        name = "experiment",
        description = {
            "Runs an experiment: a world with other values, seeds and laws. Writes tables and"
                    + " plots. If the folder contains earlier results, says whether they are"
                    + " identical, or the first difference. If an earlier command was killed,"
                    + " makes only the runs that are missing."
        })
public final class ExperimentCommand implements Callable<Integer> {
    /** File name of an experiment in a folder. */
    private static final String NAME = "experiment.yaml";

    private static final int MAX_JOBS = 256;

    /** Maximum number of runs that the printed table shows. */
    private static final int MAX_SHOWN = 40;

    @Spec private CommandSpec spec = CommandSpec.create();

    @Parameters(
            paramLabel = "FILE",
            description = "An experiment file, or a folder that contains an experiment.yaml.")
    private Path file = Path.of("");

    @Mixin private LawOptions laws = new LawOptions();

    @Mixin private PluginOptions plugins = new PluginOptions();

    @Option(
            names = "--out",
            paramLabel = "DIR",
            description =
                    "Folder for the results (default: the experiment's name and -results, in the"
                            + " current folder).")
    private Optional<Path> out = Optional.empty();

    @Option(
            names = "--jobs",
            paramLabel = "N",
            description =
                    "Number of runs at a time (default: the number of processors). Results do not"
                            + " depend on it.")
    private Optional<Integer> jobs = Optional.empty();

    @Option(
            names = "--replace",
            description = "Replace earlier results in the folder, instead of comparing with them.")
    private boolean replace;

    @Option(names = "--dry-run", description = "Check the file and all of its runs; run nothing.")
    private boolean dryRun;

    @Option(names = "--json", description = "Print the result as one JSON document.")
    private boolean json;

    @Option(
            names = "--json-lines",
            description =
                    "Print one line of JSON for each run as soon as it has ended, and one for the"
                            + " result.")
    private boolean jsonLines;

    @Override
    public Integer call() throws Exception {
        plugins.use();
        try (Interrupt interrupt = new Interrupt(spec, ExitCode.INTERRUPTED)) {
            return run(interrupt);
        }
    }

    private int run(Interrupt interrupt) throws Exception {
        int threads = jobs.orElse(Math.min(MAX_JOBS, Runtime.getRuntime().availableProcessors()));
        if (threads < 1 || threads > MAX_JOBS) {
            throw new ParameterException(
                    spec.commandLine(), "--jobs is " + threads + ", expected 1 to " + MAX_JOBS);
        }
        if (json && jsonLines) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--json and --json-lines both choose the output; leave one of them out");
        }
        if (Files.isDirectory(file)) {
            file = file.resolve(NAME);
        }
        if (!Files.exists(file)) {
            throw new NoSuchFileException(
                    "there is no experiment file " + file + "; see docs/experiments.md");
        }
        Experiment experiment = Experiment.load(file, PackFolder::open);
        if (dryRun) {
            return interrupt.endsWith(check(experiment));
        }
        if (!experiment.agents().isEmpty() && !laws.isTrusted()) {
            throw new ParameterException(
                    spec.commandLine(),
                    file
                            + " names programs of agents ("
                            + String.join(", ", experiment.agents())
                            + "), which run with all of your rights; read its `agents`, then"
                            + " permit them with --trust");
        }
        Path folder = out.orElse(Path.of(experiment.name() + "-results"));
        OptionFolder.make(spec, "--out", folder);
        var results = new ResultFolder(folder);
        requireFor(experiment, results);
        LawPath lawPath = laws.path(spec);
        try (RunJournal journal = RunJournal.open(folder, experiment, lawPath)) {
            tell(journal, experiment);
            return run(interrupt, experiment, results, folder, lawPath, journal, threads);
        }
    }

    private int run(
            Interrupt interrupt,
            Experiment experiment,
            ResultFolder results,
            Path folder,
            LawPath lawPath,
            RunJournal journal,
            int threads)
            throws Exception {
        var progress = new ExperimentProgress(System.err, experiment.runs());
        progress.resumed(journal.earlier().size());
        Set<String> warnings = new ConcurrentSkipListSet<>();
        var runs =
                new ExperimentRuns(
                        experiment,
                        lawPath,
                        folder.resolve(ResultFolder.AGENTS),
                        problem -> warn(problem, warnings, progress),
                        jsonLines
                                ? new Lines(experiment, progress, journal.earlier().size())
                                : progress,
                        journal);
        interrupt.stopWith(runs::stop);
        List<RunResult> ended = runs.run(threads);
        progress.endLine();
        if (ended.size() < experiment.runs()) {
            say(
                    "cut short after "
                            + ended.size()
                            + " of "
                            + experiment.runs()
                            + " runs; "
                            + (journal.kept() == 0
                                    ? "nothing was written"
                                    : folder.resolve(RunJournal.NAME)
                                            + " contains "
                                            + journal.kept()
                                            + " of them, and the same command continues"));
            return interrupt.endsCut();
        }
        boolean failed;
        try {
            failed = report(experiment, results, folder, ended, warnings, journal);
        } catch (IOException incomplete) {
            if (!interrupt.wasAsked()) {
                throw incomplete;
            }
            say(
                    "cut short while the results were written ("
                            + incomplete.getMessage()
                            + "); the same command writes them again");
            return interrupt.endsCut();
        }
        journal.complete();
        return interrupt.endsWith(failed);
    }

    /** Prints a line of JSON for each run that has ended. */
    private final class Lines implements RunProgress {
        private final Experiment experiment;
        private final RunProgress next;
        private int ended;

        Lines(Experiment experiment, RunProgress next, int earlier) {
            this.experiment = experiment;
            this.next = next;
            this.ended = earlier;
        }

        @Override
        public void advanced(double part) {
            next.advanced(part);
        }

        @Override
        public synchronized void ended(RunResult result) {
            next.ended(result);
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("event", "run");
            fields.put("ended", ++ended);
            fields.put("runs", experiment.runs());
            fields.putAll(ResultFolder.runFields(experiment, result));
            printLine(fields);
        }
    }

    private void printLine(Map<String, ?> fields) {
        PrintWriter output = spec.commandLine().getOut();
        output.println(Json.line(fields));
        output.flush();
    }

    /** Prints whether the command uses results of an earlier process. */
    private void tell(RunJournal journal, Experiment experiment) {
        if (!journal.earlier().isEmpty()) {
            say(
                    "continues after "
                            + journal.earlier().size()
                            + " of "
                            + experiment.runs()
                            + " runs, which an earlier command has made");
        }
        journal.dropped()
                .ifPresent(
                        reason ->
                                say(
                                        "begins with the first run: an earlier command has made"
                                                + " runs, but "
                                                + reason));
    }

    private void say(String text) {
        PrintWriter err = spec.commandLine().getErr();
        err.println("reve: " + text);
        err.flush();
    }

    private void requireFor(Experiment experiment, ResultFolder results) {
        try {
            results.requireFor(experiment);
        } catch (IOException other) {
            throw new ParameterException(spec.commandLine(), String.valueOf(other.getMessage()));
        }
    }

    private void warn(Problem problem, Set<String> warnings, ExperimentProgress progress) {
        if (warnings.add(problem.toString())) {
            progress.endLine();
            spec.commandLine().getErr().println(problem);
        }
    }

    /** Checks all runs. Returns whether one of them has a problem. */
    private boolean check(Experiment experiment) {
        PrintWriter err = spec.commandLine().getErr();
        Set<String> problems = new TreeSet<>();
        for (int i = 0; i < experiment.runs(); i++) {
            try {
                experiment.plan(i);
            } catch (WorldFileException invalid) {
                for (Problem problem : invalid.problems()) {
                    if (problems.add(problem.toString())) {
                        err.println("run " + (i + 1) + ": " + problem);
                    }
                }
            }
        }
        spec.commandLine()
                .getOut()
                .println(
                        file
                                + ": "
                                + (problems.isEmpty() ? "valid" : "not valid")
                                + ", "
                                + experiment.runs()
                                + " runs, "
                                + experiment.measures().size()
                                + " measures");
        return !problems.isEmpty();
    }

    /**
     * Writes the results or compares them with earlier ones, and prints them. Returns whether the
     * command fails.
     */
    private boolean report(
            Experiment experiment,
            ResultFolder results,
            Path folder,
            List<RunResult> ended,
            Set<String> warnings,
            RunJournal journal)
            throws IOException {
        Optional<ResultFolder.Comparison> comparison =
                results.hasResults() && !replace
                        ? Optional.of(results.compare(experiment, ended))
                        : Optional.empty();
        Optional<Difference> difference = comparison.flatMap(ResultFolder.Comparison::difference);
        Path target = difference.isPresent() ? folder.resolve(ResultFolder.CHANGED) : folder;
        List<String> plots =
                comparison.isPresent() && difference.isEmpty()
                        ? List.of()
                        : new ResultFolder(target).write(experiment, ended);
        if (json || jsonLines) {
            Map<String, Object> fields = new LinkedHashMap<>();
            if (jsonLines) {
                fields.put("event", "result");
            }
            comparison.ifPresent(
                    found -> {
                        fields.put("identical", difference.isEmpty());
                        difference.ifPresent(each -> fields.put("difference", each.fields()));
                        fields.put("since", found.since());
                    });
            fields.put("folder", target.toString());
            fields.put("plots", plots);
            fields.put("continued", journal.earlier().size());
            fields.put("warnings", List.copyOf(warnings));
            fields.putAll(ResultFolder.fields(experiment, ended));
            if (jsonLines) {
                printLine(fields);
            } else {
                Json.print(spec, fields);
            }
        } else {
            print(experiment, ended);
            tell(target, plots, comparison, ended.size());
        }
        return difference.isPresent()
                || ended.stream().anyMatch(run -> run.state() != RunResult.State.OK);
    }

    private void tell(
            Path target,
            List<String> plots,
            Optional<ResultFolder.Comparison> comparison,
            int runs) {
        PrintWriter output = spec.commandLine().getOut();
        Optional<Difference> difference = comparison.flatMap(ResultFolder.Comparison::difference);
        if (comparison.isPresent() && difference.isEmpty()) {
            output.println("identical to the results in " + target + ": " + runs + " runs");
        }
        difference.ifPresent(found -> output.println("different: " + found.message()));
        comparison.ifPresent(
                found ->
                        found.since()
                                .forEach(
                                        change ->
                                                output.println("since those results: " + change)));
        if (comparison.isEmpty() || difference.isPresent()) {
            output.println(
                    "written to "
                            + target
                            + ": "
                            + ResultFolder.RUNS
                            + ", "
                            + ResultFolder.SERIES
                            + ", "
                            + ResultFolder.RESULT
                            + ", "
                            + ResultFolder.REPORT
                            + (plots.isEmpty() ? "" : ", " + String.join(", ", plots)));
        }
        difference.ifPresent(_ -> output.println("keep the new results with --replace"));
        output.flush();
    }

    /** Prints a table of the runs with rounded numbers. */
    private void print(Experiment experiment, List<RunResult> runs) {
        List<List<String>> rows = new ArrayList<>();
        List<String> header = new ArrayList<>(List.of("run"));
        if (experiment.hasCases()) {
            header.add("case");
        }
        header.addAll(experiment.variables());
        boolean seeded = runs.stream().anyMatch(run -> run.point().seed() != 0);
        if (seeded) {
            header.add("seed");
        }
        List<String> expected = experiment.expected();
        for (String measure : experiment.measures()) {
            header.add(measure);
            if (expected.contains(measure)) {
                header.add("expected");
                header.add("error");
            }
        }
        header.add("state");
        rows.add(header);
        for (RunResult run : runs.subList(0, Math.min(MAX_SHOWN, runs.size()))) {
            rows.add(row(run, experiment, seeded));
        }
        PrintWriter output = spec.commandLine().getOut();
        for (List<String> row : rows) {
            var line = new StringBuilder();
            for (int column = 0; column < row.size(); column++) {
                int place = column;
                int width =
                        rows.stream().mapToInt(each -> each.get(place).length()).max().orElse(0);
                line.append(column == 0 ? "" : "  ")
                        .append(row.get(column))
                        .repeat(' ', width - row.get(column).length());
            }
            output.println(line.toString().stripTrailing());
        }
        if (runs.size() > MAX_SHOWN) {
            output.println("and " + (runs.size() - MAX_SHOWN) + " more runs");
        }
        runs.stream()
                .filter(run -> run.state() == RunResult.State.OUTSIDE)
                .forEach(
                        run ->
                                output.println(
                                        "run " + run.point().number() + ": " + run.message()));
        runs.forEach(
                run ->
                        run.notes()
                                .forEach(
                                        note ->
                                                output.println(
                                                        "run "
                                                                + run.point().number()
                                                                + ": "
                                                                + note)));
    }

    private static List<String> row(RunResult run, Experiment experiment, boolean seeded) {
        List<String> row = new ArrayList<>();
        row.add(Integer.toString(run.point().number()));
        run.point().itsCase().ifPresent(row::add);
        run.point().values().values().forEach(value -> row.add(Rounded.of(value)));
        if (seeded) {
            row.add(Long.toString(run.point().seed()));
        }
        for (int i = 0; i < experiment.measures().size(); i++) {
            row.add(run.values().get(i).map(ExperimentCommand::shown).orElse("-"));
            if (experiment.expected().contains(experiment.measures().get(i))) {
                row.add(run.expected().get(i).map(Rounded::of).orElse("-"));
                row.add(run.error(i).map(Rounded::of).orElse("-"));
            }
        }
        row.add(run.state().name().toLowerCase(Locale.ROOT));
        return row;
    }

    private static String shown(Object value) {
        return switch (value) {
            case Double number -> Rounded.of(number);
            case List<?> list ->
                    String.join(" ", list.stream().map(ExperimentCommand::shown).toList());
            default -> String.valueOf(value);
        };
    }
}
