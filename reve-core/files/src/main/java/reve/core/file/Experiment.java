// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.mesh.AssetException;
import reve.core.mesh.Assets;
import reve.core.mesh.WorldFolder;
import reve.core.unit.Unit;

import java.io.IOException;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalInt;
import java.util.SortedMap;
import java.util.TreeMap;
import java.util.concurrent.ConcurrentSkipListMap;

/**
 * An experiment: runs of one world with different values, seeds and laws, and the values that are
 * measured in the runs. It is read from a YAML file that follows the schema {@code
 * reve-experiment.schema.json}. Immutable. For any thread.
 */
public final class Experiment {
    /** Version of the format, the value of the key {@code experiment}. */
    public static final int FORMAT_VERSION = 1;

    /** Maximum number of frames of a run. */
    static final long MAX_FRAMES = 1_000_000_000;

    /** Maximum number of values that all runs measure. */
    static final long MAX_VALUES = 2_000_000;

    private static final Unit SECOND = Unit.parse("s");
    private static final double DEFAULT_DEADLINE_SECONDS = 60;
    private static final double MAX_DEADLINE_SECONDS = 3600;

    private final Path file;
    private final String shown;
    private final Node root;
    private final WorldPlace world;
    private final WorldSource source;
    private final SweepSpace space;
    private final double deadlineSeconds;

    /** Files that runs have read so far, by their names relative to the world's folder. */
    private final SortedMap<String, Path> read;

    /** Files that commands of agents have named so far, by their names. */
    private final SortedMap<String, Path> programs = new ConcurrentSkipListMap<>();

    /** Measures of the first run. */
    private final List<Measure> firstMeasures;

    /**
     * The world file of an experiment.
     *
     * @param shown name for messages
     * @param pack the pack from which the world file was unpacked, if the world is a pack
     */
    private record WorldPlace(Path file, String shown, Optional<Path> pack) {}

    private Experiment(
            Path file,
            String shown,
            Node root,
            WorldPlace world,
            WorldSource source,
            SweepSpace space,
            double deadlineSeconds,
            SortedMap<String, Path> read)
            throws WorldFileException {
        this.file = file;
        this.shown = shown;
        this.root = root;
        this.world = world;
        this.source = source;
        this.space = space;
        this.deadlineSeconds = deadlineSeconds;
        this.read = read;
        this.firstMeasures = plan(0).measures();
    }

    /** A function that unpacks a pack (a world in one file). */
    @FunctionalInterface
    public interface Unpacking {
        /**
         * Returns a folder with the files of a pack. The caller does not change the folder, and
         * reads it as long as the experiment runs.
         *
         * @throws PackException if the pack is damaged or exceeds the limits of packs
         */
        Path unpack(Path pack) throws IOException;
    }

    /**
     * Reads and checks an experiment with its world, which is not a pack.
     *
     * @throws WorldFileException with all problems, by line and column
     * @throws IOException if the system cannot read a file
     */
    public static Experiment load(Path file) throws WorldFileException, IOException {
        return load(
                file,
                pack -> {
                    throw new PackException(
                            pack + ": is a pack, expected a world file; unpack it first");
                });
    }

    /**
     * Reads and checks an experiment with its world.
     *
     * @param unpacking unpacks the world if it is a pack
     * @throws WorldFileException with all problems, by line and column
     * @throws IOException if the system cannot read a file
     */
    public static Experiment load(Path file, Unpacking unpacking)
            throws WorldFileException, IOException {
        String shown = file.toString();
        var problems = new Problems(shown);
        var folder = new WorldFolder(file.toAbsolutePath().getParent());
        var files = new SourceFiles(folder, shown);
        Node root =
                YamlReader.read(
                        files.read(file, problems),
                        problems,
                        new Allowance(YamlReader.MAX_OTHER_VALUES));
        SchemaCheck.checkExperiment(root, problems);
        problems.throwIfAny();
        SweepSpace space = SweepSpace.read(root, problems);
        double deadline = deadline(root, problems);
        Node worldNode = root.get("world").orElseThrow();
        Optional<SourceFiles.Source> found = files.find(worldNode, problems);
        problems.throwIfAny();
        WorldPlace world = worldPlace(worldNode, found.orElseThrow(), unpacking, problems);
        problems.throwIfAny();
        SortedMap<String, Path> read = new ConcurrentSkipListMap<>();
        WorldSource source =
                WorldSource.read(
                        world.file,
                        new WorldFolder(
                                world.file.getParent(),
                                name -> read.put(name, world.file.resolveSibling(name))),
                        problems.of(world.shown));
        problems.throwIfAny();
        return new Experiment(file, shown, root, world, source, space, deadline, read);
    }

    private static WorldPlace worldPlace(
            Node node, SourceFiles.Source found, Unpacking unpacking, Problems problems)
            throws IOException {
        if (WorldPack.isPack(found.path())) {
            try {
                return new WorldPlace(
                        unpacking.unpack(found.path()).resolve(WorldFile.NAME),
                        Path.of(found.name()).resolve(WorldFile.NAME).toString(),
                        Optional.of(found.path()));
            } catch (PackException unfit) {
                problems.add(node, "world: " + unfit.getMessage());
            }
        }
        return new WorldPlace(found.path(), found.name(), Optional.empty());
    }

    private static double deadline(Node root, Problems problems) {
        Optional<Node> node = root.get("deadline");
        double seconds =
                node.flatMap(each -> new Quantities(problems).number(each, SECOND))
                        .orElse(DEFAULT_DEADLINE_SECONDS);
        if (!(seconds > 0 && seconds <= MAX_DEADLINE_SECONDS)) {
            problems.add(
                    node.orElse(root),
                    "deadline: found "
                            + seconds
                            + " s, expected more than 0 and at most "
                            + MAX_DEADLINE_SECONDS
                            + " s");
        }
        return seconds;
    }

    /** Returns the path of the experiment file, in the form in which the caller gave it. */
    public Path file() {
        return file;
    }

    /** Returns the folder of the experiment file. */
    public Path folder() {
        Path parent = file.toAbsolutePath().getParent();
        return parent == null ? Path.of("/") : parent;
    }

    /** Returns the folder of the world file; for a pack, the folder with its files. */
    public Path worldFolder() {
        return world.file.getParent();
    }

    /** Returns the name of the experiment. */
    public String name() {
        return root.get("name").flatMap(Node::text).orElseThrow();
    }

    /** Returns the description for people; empty if the file has none. */
    public String doc() {
        return root.get("doc").flatMap(Node::text).orElse("");
    }

    /** Returns the number of runs. */
    public int runs() {
        return space.count();
    }

    /** Returns the names of the swept variables. */
    public List<String> variables() {
        return space.variables();
    }

    /**
     * Returns whether the experiment has cases (named sets of values), of which each run uses one.
     */
    public boolean hasCases() {
        return space.hasCases();
    }

    /** Returns the number of frames between two measurements; empty if only the end is measured. */
    public OptionalInt every() {
        Optional<Double> every = root.get("every").flatMap(Node::number);
        return every.isPresent() ? OptionalInt.of(every.get().intValue()) : OptionalInt.empty();
    }

    /** Returns the names of the measures. */
    public List<String> measures() {
        return root.get("measures").orElseThrow().children().stream().map(Node::key).toList();
    }

    /** Returns the names of the measures with an expected value. */
    public List<String> expected() {
        return root.get("measures").orElseThrow().children().stream()
                .filter(node -> node.get("expected").isPresent())
                .map(Node::key)
                .toList();
    }

    /** Returns the names of the agents whose programs the file names. */
    public List<String> agents() {
        return agentNodes().stream().map(Node::key).toList();
    }

    /**
     * Returns the maximum time for agents to join, and for one answer of an agent [s of the wall
     * clock].
     */
    public double deadlineSeconds() {
        return deadlineSeconds;
    }

    /**
     * Returns the files that the experiment has read so far, and the files in its folder that
     * commands of agents have named. Their names are relative to the folder of the experiment or of
     * the world. A pack is one file.
     */
    public SortedMap<String, Path> inputs() {
        SortedMap<String, Path> inputs = new TreeMap<>(programs);
        if (world.pack.isEmpty()) {
            inputs.putAll(read);
        }
        inputs.put(String.valueOf(file.getFileName()), file);
        Path shared = world.pack.orElse(world.file);
        inputs.put(String.valueOf(shared.getFileName()), shared);
        return Collections.unmodifiableSortedMap(inputs);
    }

    /**
     * Returns the file that a run of this experiment would have read under a name of {@link
     * #inputs}; empty if there is no such file.
     */
    public Optional<Path> findInput(String name) {
        Path known = inputs().get(name);
        if (known != null) {
            return Optional.of(known);
        }
        Optional<Path> ofWorld =
                world.pack.isPresent() ? Optional.empty() : find(worldFolder(), name);
        return ofWorld.or(() -> find(folder(), name));
    }

    private static Optional<Path> find(Path folder, String name) {
        try {
            return Optional.of(new WorldFolder(folder).find(name));
        } catch (AssetException none) {
            return Optional.empty();
        }
    }

    /**
     * Adds a file to {@link #inputs} that a run has read in an earlier process.
     *
     * @param name a name for which {@link #findInput} has found a file
     */
    public void addInput(String name) {
        findInput(name)
                .ifPresent(
                        found ->
                                (find(folder(), name).filter(found::equals).isPresent()
                                                ? programs
                                                : read)
                                        .putIfAbsent(name, found));
    }

    /** Returns the SI unit of a variable; empty if its values have no unit in the file. */
    public Optional<Unit> variableUnit(String variable) {
        return space.unit(variable);
    }

    /**
     * Returns the unit in which plots show the measurements during a run; empty if it is not known.
     *
     * @param measure index in {@link #measures}
     */
    public Optional<Unit> measurementUnit(int measure) {
        return firstMeasures.get(measure).unit();
    }

    /**
     * Returns the unit in which plots show the value of a measure for the table of runs; empty if
     * it is not known.
     *
     * @param measure index in {@link #measures}
     */
    public Optional<Unit> valueUnit(int measure) {
        return firstMeasures.get(measure).unitOfRuns();
    }

    /**
     * Returns the values by which a run differs from the other runs.
     *
     * @param run number of the run, from 0
     */
    public RunPoint point(int run) {
        return space.point(run);
    }

    /**
     * Reads and checks the plan of a run: its world, its changes of laws, and its measures.
     *
     * @param run number of the run, from 0
     * @throws WorldFileException with all problems that the values of this run cause
     */
    public RunPlan plan(int run) throws WorldFileException {
        RunPoint point = space.point(run);
        var problems = new Problems(world.shown);
        var folder =
                new WorldFolder(
                        worldFolder(), name -> read.put(name, world.file.resolveSibling(name)));
        List<Node> sets = new ArrayList<>();
        root.get("set").ifPresent(set -> sets.add(evaluated(set, point, problems)));
        space.caseOf(run).ifPresent(set -> sets.add(evaluated(set, point, problems)));
        problems.throwIfAny();
        WorldDescription description =
                new WorldReader(new Assets(folder), problems)
                        .read(
                                Overrides.apply(
                                        source,
                                        sets,
                                        new SourceFiles(folder, world.shown),
                                        point.seed(),
                                        problems));
        var own = problems.of(shown);
        long frames = frames(description, point, own);
        own.throwIfAny();
        List<LawStep> steps =
                new LawStepReader(description, frames, own)
                        .readAll(
                                root.get("schedule")
                                        .map(node -> evaluatedChanges(node, point, own))
                                        .orElse(List.of()));
        List<Measure> measures =
                new MeasureReader(description, every().isPresent(), own)
                        .readAll(
                                root.get("measures").orElseThrow().children(),
                                expected(point, own));
        requireRoom(frames, own);
        requireAgents(description, own);
        agentNodes().forEach(agent -> addPrograms(evaluated(agent, point, 1, own)));
        own.throwIfAny();
        return new RunPlan(point, description, frames, steps, measures, programs(point));
    }

    /** Adds the files in the experiment's folder that the command of an agent names. */
    private void addPrograms(Node agent) {
        for (Node node : agent.get("command").map(Node::children).orElse(List.of())) {
            String word = word(node);
            find(folder(), word).ifPresent(program -> programs.put(word, program));
        }
    }

    private long frames(WorldDescription world, RunPoint point, Problems problems) {
        Node seconds = value("seconds", root.get("seconds").orElseThrow(), point, problems);
        Optional<Double> time = new Quantities(problems).number(seconds, SECOND);
        double frames = time.orElse(1.0) * world.timing().framesPerSecond();
        if (!(frames >= 0.5 && frames <= MAX_FRAMES)) {
            problems.add(
                    seconds,
                    "seconds: are "
                            + Math.rint(frames)
                            + " frames, expected 1 to "
                            + MAX_FRAMES
                            + " frames in a run");
            return 1;
        }
        return Math.round(frames);
    }

    private Map<String, Node> expected(RunPoint point, Problems problems) {
        Map<String, Node> expected = new LinkedHashMap<>();
        for (Node measure : root.get("measures").orElseThrow().children()) {
            measure.get("expected")
                    .ifPresent(
                            node ->
                                    expected.put(
                                            measure.key(),
                                            value("expected", node, point, problems)));
        }
        return expected;
    }

    private void requireRoom(long frames, Problems problems) {
        if (every().isEmpty()) {
            return;
        }
        double values = (double) runs() * measures().size() * (frames / every().getAsInt() + 2);
        if (values > MAX_VALUES) {
            problems.add(
                    root.get("every").orElseThrow(),
                    "every: all runs measure about "
                            + (long) values
                            + " values, expected at most "
                            + MAX_VALUES
                            + "; measure less often");
        }
    }

    private void requireAgents(WorldDescription world, Problems problems) {
        if (!agentNodes().isEmpty()
                && world.agents().bodies().isEmpty()
                && world.agents().template().isEmpty()) {
            problems.add(
                    root.get("agents").orElseThrow(),
                    "agents: the world file grants agents no body, so none can join; see the key"
                            + " `agents` of world files");
        }
    }

    private List<Node> agentNodes() {
        return root.get("agents").map(node -> List.copyOf(node.children())).orElse(List.of());
    }

    private List<AgentProgram> programs(RunPoint point) {
        return agentNodes().stream()
                .map(
                        agent ->
                                new AgentProgram(
                                        agent.key(),
                                        port ->
                                                evaluated(agent, point, port, new Problems(shown))
                                                        .get("command")
                                                        .orElseThrow()
                                                        .children()
                                                        .stream()
                                                        .map(Experiment::word)
                                                        .toList()))
                .toList();
    }

    /**
     * Returns an argument of a program. The value of an argument that is only a formula is a
     * number.
     */
    private static String word(Node node) {
        return node.text()
                .orElseGet(() -> YamlWriter.Numeral.of(node.number().orElse(Double.NaN)).text());
    }

    /**
     * Evaluates the formulas of the schedule. Texts of laws are an exception, because they contain
     * braces.
     */
    private List<Node> evaluatedChanges(Node schedule, RunPoint point, Problems problems) {
        List<Node> changes = new ArrayList<>();
        for (Node change : schedule.children()) {
            Node evaluated = evaluated(change.without("text"), point, problems);
            changes.add(
                    change.get("text")
                            .map(
                                    text ->
                                            evaluated.over(
                                                    change.withValue(
                                                            new LinkedHashMap<>(
                                                                    Map.of("text", text)))))
                            .orElse(evaluated));
        }
        return changes;
    }

    /** Returns one value with its formulas evaluated. */
    private Node value(String key, Node node, RunPoint point, Problems problems) {
        Node alone = root.withValue(new LinkedHashMap<>(Map.of(key, node)));
        return evaluated(alone, point, problems).get(key).orElseThrow();
    }

    private Node evaluated(Node mapping, RunPoint point, Problems problems) {
        return evaluated(mapping, point, -1, problems);
    }

    /**
     * Evaluates the formulas of a mapping.
     *
     * @param port value of the variable {@code port}; below 0 if there is no such variable
     */
    private Node evaluated(Node mapping, RunPoint point, int port, Problems problems) {
        List<String> names = new ArrayList<>(point.values().keySet());
        List<Double> values = new ArrayList<>(point.values().values());
        names.addAll(List.of("seed", "run"));
        values.addAll(List.of((double) point.seed(), (double) point.number()));
        if (port >= 0) {
            names.add("port");
            values.add((double) port);
        }
        return new Template(mapping, names, problems, point.seed())
                .make(values.stream().mapToDouble(Double::doubleValue).toArray(), 0);
    }
}
