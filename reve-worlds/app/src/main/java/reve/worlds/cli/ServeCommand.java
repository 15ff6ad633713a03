// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.jspecify.annotations.Nullable;

import picocli.CommandLine.ArgGroup;
import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;
import picocli.CommandLine.Spec;

import reve.core.agent.AgentServerConfig;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFileException;
import reve.core.file.WorldPack;
import reve.core.frame.Pacing;
import reve.core.mesh.AssetException;
import reve.core.text.Rounded;
import reve.worlds.cluster.ClusterNode;
import reve.worlds.cluster.NodeSettings;
import reve.worlds.journal.JournalSink;
import reve.worlds.journal.PostgresCatalog;
import reve.worlds.journal.PostgresStore;
import reve.worlds.journal.PostgresUrl;
import reve.worlds.journal.RecordingPlan;
import reve.worlds.journal.SqliteStore;
import reve.worlds.journal.StoreAddress;
import reve.worlds.server.LawPath;
import reve.worlds.server.Persistence;
import reve.worlds.server.Pictures;
import reve.worlds.server.ServerReport;
import reve.worlds.server.WatchdogPlan;
import reve.worlds.server.WorldHost;
import reve.worlds.server.WorldPlan;
import reve.worlds.server.WorldServer;
import reve.worlds.web.PageWorld;
import reve.worlds.web.WebServer;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.security.MessageDigest;
import java.security.NoSuchAlgorithmException;
import java.time.Duration;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.HexFormat;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.TreeMap;
import java.util.concurrent.Callable;
import java.util.regex.Pattern;

/** The command {@code serve}: runs worlds that agents can join, until Ctrl-C. */
@Command(
        name = "serve",
        description =
                "Runs worlds that agents can join and that load laws while they run, "
                        + "until Ctrl-C.")
public final class ServeCommand implements Callable<Integer> {
    /** Names of the files of a store in the folder of {@code --store}. */
    private static final Pattern STORE_FILE = Pattern.compile(".+\\.db(-.*)?");

    private static final int STORE_EVERY = 10;
    private static final double MIN_DEADLINE = 0.001;
    private static final double MAX_DEADLINE = 3600;
    private static final double MIN_WAITING = 0.001;
    private static final double MAX_WAITING = 86_400;
    private static final String NO_LIMIT = "off";
    private static final double MIN_WATCHDOG = 0.1;
    private static final double MAX_WATCHDOG = 86_400;
    private static final Duration LAW_DEADLINE = Duration.ofMillis(50);

    /** Number of worlds that keep a second process of the engine, which has loaded their laws. */
    private static final int READY_WORLDS = 4;

    private static final Duration LAST_WORDS = Duration.ofSeconds(1);

    /** Maximum time in which a node hands its worlds over and leaves the cluster. */
    private static final Duration LEAVING = Duration.ofSeconds(90);

    @Spec private CommandSpec spec = CommandSpec.create();

    @Parameters(
            paramLabel = "WORLD",
            arity = "0..*",
            description =
                    "World files, or folders that hold a world.yaml. Each world runs by itself. With a"
                            + " --store URL, also names of worlds that the database has. A node of"
                            + " a --cluster adds these worlds to the database, and needs none.")
    private List<Path> paths = new ArrayList<>();

    @Mixin private ListenOptions listen = new ListenOptions();

    @Mixin private LawOptions laws = new LawOptions();

    @Mixin private PluginOptions plugins = new PluginOptions();

    @Mixin private SwapOptions swaps = new SwapOptions();

    @Mixin private EngineOptions engine = new EngineOptions();

    @Option(
            names = "--without-law",
            paramLabel = "NAME",
            description =
                    "Run the worlds without this law library, even if a world file, a store or the"
                            + " folder of --laws has it. May be repeated.")
    private List<String> withoutLaws = new ArrayList<>();

    @Option(
            names = "--seconds",
            paramLabel = "S",
            description = "Stop after this much world time [s].")
    private Optional<Double> seconds = Optional.empty();

    @Option(
            names = "--until-input-ends",
            description =
                    "Stop when the standard input ends. A program that starts the server and keeps"
                            + " the input open leaves no server behind, also if it is killed.")
    private boolean untilInputEnds;

    @Option(
            names = "--pictures",
            paramLabel = "DIR",
            defaultValue = ".",
            description = "Folder for pictures (default: the current folder).")
    private Path pictures = Path.of(".");

    @Option(
            names = "--picture-at",
            paramLabel = "S",
            split = ",",
            description = "World times to take pictures at [s], for example 0,2.5,5.")
    private List<Double> pictureAt = new ArrayList<>();

    @Option(
            names = "--store",
            paramLabel = "FILE",
            description =
                    "Keep the world in this store file, and resume from it. With several worlds, the"
                            + " file is a folder with a WORLD.db for each."
                            + " postgresql://USER@HOST:PORT/DATABASE: keep the worlds in a database"
                            + " that several servers share.")
    private Optional<StoreArgument> store = Optional.empty();

    /** Worlds of a cluster by name and content of their pack. Guarded by the lock of this map. */
    private final Map<String, WorldArgument> unpacked = new HashMap<>();

    /**
     * Files with packs of worlds for a shared store. They are removed when the store contains the
     * packs.
     */
    private final List<Path> packs = new ArrayList<>();

    @Option(
            names = "--store-every",
            paramLabel = "S",
            description =
                    "World time between two images in the store [s] "
                            + "(default: "
                            + STORE_EVERY
                            + ").")
    private Optional<Double> storeEvery = Optional.empty();

    @Option(
            names = "--durability",
            paramLabel = "KIND",
            description =
                    "What the store survives. normal (default): the end of the process. full:"
                            + " also a power failure; the world then waits for slow disks.")
    private Optional<SqliteStore.Durability> durability = Optional.empty();

    @Option(
            names = "--standby",
            description =
                    "Wait until the server that has the world ends or is lost, then continue the"
                            + " world. Takes one world and a --store URL.")
    private boolean standby;

    @Mixin private ClusterOptions cluster = new ClusterOptions();

    @Mixin private RecordOptions record = new RecordOptions();

    @Option(
            names = "--saves",
            paramLabel = "DIR",
            description = "Folder for world files that clients of the role control save.")
    private Optional<Path> saves = Optional.empty();

    @Mixin private AuditOptions audit = new AuditOptions();

    @Option(
            names = "--deadline",
            paramLabel = "S",
            defaultValue = "1",
            description =
                    "Longest time that the world waits for an agent in lock-step [s] "
                            + "(default: ${DEFAULT-VALUE}).")
    private double deadline;

    @Option(
            names = "--waiting",
            paramLabel = "S",
            defaultValue = "10",
            description =
                    "Time that an agent in lock-step may delay others [s], in addition to a "
                            + "tenth of all time; off: no limit (default: ${DEFAULT-VALUE}).")
    private String waiting;

    @Option(
            names = "--watchdog",
            paramLabel = "S",
            defaultValue = "5",
            description =
                    "Time without a frame after which a world counts as stalled [s]; "
                            + "0 disables the watchdog (default: ${DEFAULT-VALUE}).")
    private double watchdog;

    @Option(
            names = "--stalled",
            paramLabel = "WHAT",
            defaultValue = "warn",
            description =
                    "Reaction to a stalled world. warn: a report; exit: a "
                            + "report, then the server ends at once with code 6.")
    private Stalled stalled = Stalled.WARN;

    private enum Stalled {
        WARN,
        EXIT
    }

    @Option(
            names = "--fast",
            description = "Make frames as fast as possible, instead of paced to the wall clock.")
    private boolean fast;

    @Option(
            names = "--json",
            description = "Report events as one JSON object per line on standard output.")
    private boolean json;

    @ArgGroup private PrintedOptions printed = new PrintedOptions();

    /** The options that select the printed events; at most one may be given. */
    static final class PrintedOptions {
        @Option(
                names = "--quiet",
                description = "Print only that worlds are ready, faults, and the end.")
        private boolean quiet;

        @Option(
                names = "--actions",
                description =
                        "Also print each action of agents, and the events that actions raise.")
        private boolean actions;

        Printed printed() {
            return quiet ? Printed.LITTLE : actions ? Printed.ACTIONS : Printed.NORMAL;
        }
    }

    @Override
    public Integer call() throws Exception {
        plugins.use();
        try (Interrupt interrupt = new Interrupt(spec, ExitCode.OK)) {
            if (cluster.isGiven()) {
                return interrupt.endsWith(serveInCluster(interrupt));
            }
            cluster.requireNone();
            return interrupt.endsWith(serve(interrupt).failed());
        }
    }

    private ServerReport serve(Interrupt interrupt) throws Exception {
        if (paths.isEmpty()) {
            throw new ParameterException(spec.commandLine(), "Missing required parameter: 'WORLD'");
        }
        AgentServerConfig agents = agents();
        listen.web();
        requireWatchdog();
        requireStoreEvery();
        requireOwnFiles();
        requireStandby();
        List<WorldPlan> plans = standby ? List.of() : plans();
        try (EventPrinter events = events()) {
            WorldServer server =
                    standby ? successor(agents, events) : server(plans, agents, events);
            interrupt.stopWith(server::stop);
            if (untilInputEnds) {
                InputEnd.then(server::stop);
            }
            Warnings.print(spec, server.warnings());
            ServerReport report;
            try (server;
                    WebServer page = page(agents, server)) {
                server.start(Optional.ofNullable(page).map(WebServer::address));
                report = server.run();
            }
            report = report.lacking(server.unkept(), server.gaps());
            events.end(report);
            return report;
        }
    }

    /** Serves worlds as a node of a cluster; returns whether the node or a world failed. */
    private boolean serveInCluster(Interrupt interrupt) throws Exception {
        requireOptionsOfNodes();
        listen.web();
        requireWatchdog();
        requireStoreEvery();
        requireOwnFiles();
        NodeSettings settings = cluster.settings(store);
        cluster.warn(settings);
        AgentServerConfig agents = agents();
        if (agents.address().getAddress().isAnyLocalAddress()) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--listen "
                            + agents.address().getHostString()
                            + " stands for all addresses of this machine; in a cluster, name the"
                            + " one at which agents on other machines reach it");
        }
        LawPath lawPath = lawPath();
        Map<String, Path> added = packedWorlds();
        makeFolders();
        try (EventPrinter events = events()) {
            boolean wasRemoved;
            WorldHost host =
                    new WorldHost(
                            fast ? Pacing.FAST : Pacing.REAL_TIME,
                            agents,
                            laws.folder(),
                            watchdog(events),
                            events);
            try (host;
                    WebServer _ = nodesPage(agents, host);
                    ClusterNode node =
                            ClusterNode.start(
                                    settings, host, name -> planInCluster(name, lawPath), events)) {
                interrupt.stopWith(node::stop, LEAVING);
                if (!added.isEmpty()) {
                    node.beginAdding();
                }
                node.awaitUp();
                addWorlds(settings.database(), added);
                node.endAdding();
                wasRemoved = node.await().isPresent();
            }
            ServerReport report = host.report();
            events.end(report);
            return wasRemoved || report.failed();
        }
    }

    /** Starts the pages of a node: that of its worlds, and that of the nodes of the cluster. */
    private @Nullable WebServer nodesPage(AgentServerConfig agents, WorldHost host)
            throws IOException {
        Optional<InetSocketAddress> address = listen.web();
        if (address.isEmpty()) {
            return null;
        }
        WebServer page =
                WebServer.start(address.get(), agents.security(), host.agents(), host::cluster);
        host.show(page);
        return page;
    }

    private void requireOptionsOfNodes() {
        Map<String, Boolean> foreign = new LinkedHashMap<>();
        foreign.put("--standby", standby);
        foreign.put("--seconds", seconds.isPresent());
        foreign.put("--until-input-ends", untilInputEnds);
        foreign.put("--record", record.file().isPresent());
        foreign.put("--picture-at", !pictureAt.isEmpty());
        foreign.forEach(
                (option, isGiven) -> {
                    if (isGiven) {
                        throw new ParameterException(
                                spec.commandLine(),
                                option
                                        + " is for a server whose worlds are known when it starts;"
                                        + " found --cluster, whose nodes get worlds and lose"
                                        + " them"
                                        + (option.equals("--record")
                                                ? ". The database has the frames since the third"
                                                        + " last image: replay WORLD --store URL"
                                                        + " repeats them, and a longer"
                                                        + " --store-every keeps more of them"
                                                : ""));
                    }
                });
    }

    /** Packs the worlds of the command line. Omits worlds that exist in the database only. */
    private Map<String, Path> packedWorlds() throws Exception {
        Map<String, Path> packed = new LinkedHashMap<>();
        for (Path path : paths) {
            WorldArgument world = world(path);
            String name = engine.of(spec, world.read()).name();
            Optional<Path> pack = packOf(world);
            pack.ifPresent(file -> packed.put(name, file));
        }
        return packed;
    }

    /** Adds worlds to the database, unless it has worlds of these names. */
    private void addWorlds(PostgresUrl url, Map<String, Path> added) throws IOException {
        try (PostgresCatalog catalog = new PostgresCatalog(url)) {
            for (Map.Entry<String, Path> world : added.entrySet()) {
                catalog.add(world.getKey(), world.getValue());
            }
        } finally {
            removePacks();
        }
    }

    private WorldPlan planInCluster(String name, LawPath lawPath)
            throws IOException, WorldFileException {
        PostgresUrl url = database().orElseThrow();
        byte[] pack =
                PostgresStore.pack(url, name)
                        .orElseThrow(
                                () ->
                                        new NoSuchFileException(
                                                url + " has no pack of the world " + name));
        WorldArgument world = unpacked(name, pack);
        WorldDescription description = engine.of(spec, world.read());
        return plan(
                description,
                world.folder(),
                Optional.of(new StoreAddress.InDatabase(url, name, Optional.empty())),
                lawPath);
    }

    /**
     * Returns the files of a pack. This process unpacks them once, and again if they were removed,
     * for example by a program that cleans the folder of temporary files.
     */
    private WorldArgument unpacked(String name, byte[] pack) throws IOException {
        String content;
        try {
            byte[] digest = MessageDigest.getInstance("SHA-256").digest(pack);
            content = name + " " + HexFormat.of().formatHex(digest);
        } catch (NoSuchAlgorithmException e) {
            throw new IllegalStateException("each Java has SHA-256", e);
        }
        synchronized (unpacked) {
            WorldArgument known = unpacked.get(content);
            if (known == null || !Files.exists(known.file())) {
                known = WorldArgument.unpacked(name, pack);
                unpacked.put(content, known);
            }
            return known;
        }
    }

    private EventPrinter events() {
        return new EventPrinter(
                (LinePrinter) spec.commandLine().getOut(),
                spec.commandLine().getErr(),
                json,
                printed.printed());
    }

    private void requireStandby() {
        if (standby && (database().isEmpty() || paths.size() > 1)) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--standby takes one world and --store postgresql://USER@HOST:PORT/DATABASE;"
                            + " found "
                            + (paths.size() > 1
                                    ? paths.size() + " worlds: start one server for each"
                                    : store.map(named -> "--store " + named.given())
                                            .orElse("no --store")));
        }
    }

    /** Waits until no server has the world, and takes it. */
    private WorldServer successor(AgentServerConfig agents, EventPrinter events)
            throws IOException, WorldFileException, AssetException {
        Path path = paths.getFirst();
        boolean isFile = Files.exists(path);
        String name = isFile ? new WorldArgument(path).read().name() : path.toString();
        while (true) {
            PostgresStore.awaitFree(
                    database().orElseThrow(),
                    name,
                    !isFile,
                    owner -> events.happened("standby", standbyFields(owner)),
                    problem -> storeFault(events, problem));
            try {
                return server(plans(), agents, events);
            } catch (JournalSink.InUseException faster) {
                // The exception is ignored. Another server in standby has taken the world, so this
                // server continues to wait.
            } catch (JournalSink.AwayException away) {
                storeFault(events, away.getMessage() + "; this server waits for it");
            }
        }
    }

    private static void storeFault(EventPrinter events, String problem) {
        events.happened(
                "fault", new LinkedHashMap<>(Map.of("source", "store", "message", problem)));
    }

    private static Map<String, Object> standbyFields(PostgresStore.World owner) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("world", owner.name());
        fields.put("owner", owner.owner());
        fields.put("epoch", owner.epoch());
        fields.put("frame", owner.frame());
        fields.put("pid", ProcessHandle.current().pid());
        return fields;
    }

    private WorldServer server(List<WorldPlan> plans, AgentServerConfig agents, EventPrinter events)
            throws IOException {
        try {
            return new WorldServer(
                    plans,
                    fast ? Pacing.FAST : Pacing.REAL_TIME,
                    agents,
                    laws.folder(),
                    watchdog(events),
                    events);
        } finally {
            removePacks();
        }
    }

    private void removePacks() throws IOException {
        for (Path pack : packs) {
            Files.deleteIfExists(pack);
        }
        packs.clear();
    }

    private @Nullable WebServer page(AgentServerConfig agents, WorldServer server)
            throws IOException {
        Optional<InetSocketAddress> address = listen.web();
        if (address.isEmpty()) {
            return null;
        }
        List<PageWorld> worlds = new ArrayList<>();
        for (int i = 0; i < server.ports().size(); i++) {
            worlds.add(new PageWorld(server.ports().get(i), server.descriptions().get(i).camera()));
        }
        return WebServer.start(address.get(), agents.security(), server.agents(), worlds);
    }

    private List<WorldPlan> plans() throws IOException, WorldFileException, AssetException {
        LawPath lawPath = lawPath();
        Map<String, WorldPlan> plans = new LinkedHashMap<>();
        for (Path path : paths) {
            WorldArgument world = world(path);
            world.requireLasting(spec, "--store", storeFile().isPresent());
            world.requireLasting(spec, "--record", record.file().isPresent());
            WorldDescription description = engine.of(spec, world.read());
            WorldPlan plan =
                    plan(description, world.folder(), address(description.name(), world), lawPath);
            if (plans.put(description.name(), plan) != null) {
                throw new ParameterException(
                        spec.commandLine(),
                        "two worlds are called "
                                + description.name()
                                + ", expected different names: agents tell them apart by these");
            }
        }
        makeFolders();
        return List.copyOf(plans.values());
    }

    private LawPath lawPath() throws IOException {
        return engine.of(laws.path(spec, LAW_DEADLINE, READY_WORLDS))
                .without(Set.copyOf(withoutLaws));
    }

    private Optional<PostgresUrl> database() {
        return store.flatMap(StoreArgument::url);
    }

    private Optional<Path> storeFile() {
        return store.flatMap(StoreArgument::file);
    }

    /** Returns the world of a path, or the world of this name in the shared store. */
    private WorldArgument world(Path path) throws IOException {
        if (database().isEmpty() || Files.exists(path)) {
            return new WorldArgument(path);
        }
        Optional<byte[]> pack = PostgresStore.pack(database().get(), path.toString());
        if (pack.isEmpty()) {
            List<String> names = store.orElseThrow().worlds();
            throw new NoSuchFileException(
                    "there is no world file "
                            + path
                            + ", and "
                            + database().get()
                            + (names.isEmpty()
                                    ? " has no world"
                                    : " has no world of this name, it has "
                                            + String.join(", ", names))
                            + "; name a world file, or a world of the database");
        }
        return WorldArgument.unpacked(path.toString(), pack.get());
    }

    /**
     * Returns the place where a world is stored. A shared store also receives the world's files.
     */
    private Optional<StoreAddress> address(String name, WorldArgument world)
            throws IOException, WorldFileException, AssetException {
        if (database().isEmpty()) {
            return fileOf(storeFile(), name + ".db").map(StoreAddress.InFile::new);
        }
        return Optional.of(new StoreAddress.InDatabase(database().get(), name, packOf(world)));
    }

    /** Packs a world; returns empty if it is in the database only. */
    private Optional<Path> packOf(WorldArgument world)
            throws IOException, WorldFileException, AssetException {
        if (!Files.exists(world.shown())) {
            return Optional.empty();
        }
        Path file = Files.createTempFile("reve-", WorldPack.ENDING);
        packs.add(file);
        if (world.isPack()) {
            Files.copy(world.shown(), file, StandardCopyOption.REPLACE_EXISTING);
        } else {
            WorldPack.write(file, PackedFiles.of(spec, world, laws.folder()).files());
        }
        return Optional.of(file);
    }

    /** Refuses two options that would write to the same file, before any file is opened. */
    private void requireOwnFiles() throws IOException {
        Map<Path, String> taken = new LinkedHashMap<>();
        Map<String, Optional<Path>> readFiles = new TreeMap<>(listen.files());
        readFiles.putAll(cluster.files());
        for (Map.Entry<String, Optional<Path>> read : readFiles.entrySet()) {
            if (read.getValue().isPresent()) {
                taken.put(real(read.getValue().get()), read.getKey());
            }
        }
        for (Path path : paths) {
            taken.put(real(new WorldArgument(path).shown()), "the world " + path);
        }
        requireOwn(taken, "--store", storeFile());
        requireOwn(taken, "--record", record.file());
        requireOwn(taken, "--audit", audit.file());
    }

    /**
     * Records the file of an option. Refuses the file if another option uses it. The check includes
     * derived names. A store uses names that begin with its name and {@code -}; with several
     * worlds, {@code --store} is a folder of stores whose names end in {@code .db}. Older
     * recordings and audit files are named {@code FILE.1} and so on.
     */
    private void requireOwn(Map<Path, String> taken, String option, Optional<Path> given)
            throws IOException {
        if (given.isEmpty()) {
            return;
        }
        Path file = real(given.get());
        if (file.getParent() == null) {
            return; // the path is the root folder, which is never a file
        }
        taken.forEach(
                (other, by) -> {
                    boolean isStores =
                            by.equals("--store")
                                    && file.startsWith(other.getParent())
                                    && file.getFileName()
                                            .toString()
                                            .startsWith(other.getFileName() + "-");
                    boolean isOfWorlds =
                            by.equals("--store")
                                    && paths.size() > 1
                                    && other.equals(file.getParent())
                                    && STORE_FILE.matcher(file.getFileName().toString()).matches();
                    boolean isOlder =
                            !by.equals("--store") && isOlder(file, other)
                                    || !option.equals("--store") && isOlder(other, file);
                    if (file.equals(other) || isStores || isOfWorlds || isOlder) {
                        throw new ParameterException(
                                spec.commandLine(),
                                option
                                        + " "
                                        + given.get()
                                        + " is a file of "
                                        + by
                                        + "; give each a file of its own");
                    }
                });
        taken.put(file, option);
    }

    /** Returns a path in which all links are resolved. */
    private static Path real(Path given) throws IOException {
        Path file = given.toAbsolutePath().normalize();
        return Files.exists(file)
                ? file.toRealPath()
                : Files.isDirectory(file.getParent())
                        ? file.getParent().toRealPath().resolve(file.getFileName())
                        : file;
    }

    private static boolean isOlder(Path older, Path file) {
        return file.getParent().equals(older.getParent())
                && older.getFileName()
                        .toString()
                        .matches(Pattern.quote(file.getFileName() + ".") + "[0-9]+");
    }

    private void makeFolders() {
        makeFolder("--pictures", Optional.of(pictures));
        makeFolder("--saves", saves);
        if (paths.size() > 1) {
            makeFolder("--record", record.file());
            makeFolder("--store", storeFile());
        }
    }

    private void makeFolder(String option, Optional<Path> folder) {
        if (folder.isPresent()) {
            OptionFolder.make(spec, option, folder.get());
        }
    }

    private WorldPlan plan(
            WorldDescription description,
            Path folder,
            Optional<StoreAddress> address,
            LawPath lawPath) {
        Optional<Path> ownSaves =
                saves.map(all -> isOfSeveral() ? all.resolve(description.name()) : all);
        makeFolder("--saves", saves);
        makeFolder("--saves", ownSaves);
        List<Long> pictureFrames = new ArrayList<>();
        for (double time : pictureAt) {
            pictureFrames.add(Frames.of(spec, "--picture-at", time, description.timing()));
        }
        return new WorldPlan(
                description,
                Frames.of(spec, "--seconds", seconds, description.timing()),
                new Persistence(
                        folder,
                        recording(description.name()),
                        address,
                        ownSaves,
                        storeEvery.orElse((double) STORE_EVERY),
                        durability.orElse(SqliteStore.Durability.NORMAL)),
                new Pictures(pictures, pictureFrames),
                lawPath.forWorld(folder),
                swaps.plan(spec));
    }

    /** Returns whether the server may have several worlds. */
    private boolean isOfSeveral() {
        return paths.size() > 1 || cluster.isGiven();
    }

    private Optional<RecordingPlan> recording(String world) {
        return record.plan()
                .map(
                        plan ->
                                new RecordingPlan(
                                        fileOf(Optional.of(plan.file()), world + ".log")
                                                .orElseThrow(),
                                        plan.maxBytes(),
                                        plan.keep()));
    }

    /**
     * Returns the file of one world for an option. The result is the named file if there is a
     * single world. Otherwise it is a file in the named folder.
     */
    private Optional<Path> fileOf(Optional<Path> named, String name) {
        return paths.size() > 1 ? named.map(folder -> folder.resolve(name)) : named;
    }

    private void requireStoreEvery() {
        if (storeEvery.isPresent() && !(storeEvery.get() > 0)) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--store-every is "
                            + Rounded.of(storeEvery.get())
                            + ", expected a time above 0 s");
        }
        PartnerOption.require(spec, "--store-every", storeEvery.isPresent(), "--store FILE", store);
        PartnerOption.require(spec, "--durability", durability.isPresent(), "--store FILE", store);
    }

    private void requireWatchdog() {
        if (watchdog != 0 && !(watchdog >= MIN_WATCHDOG && watchdog <= MAX_WATCHDOG)) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--watchdog is "
                            + Rounded.of(watchdog)
                            + ", expected 0 or "
                            + Rounded.of(MIN_WATCHDOG)
                            + " to "
                            + Rounded.of(MAX_WATCHDOG)
                            + " s");
        }
    }

    private WatchdogPlan watchdog(EventPrinter events) {
        return new WatchdogPlan(
                Duration.ofNanos(Math.round(watchdog * 1e9)),
                stalled == Stalled.EXIT ? Optional.of(() -> exit(events)) : Optional.empty());
    }

    /**
     * Ends the process although the thread of a world hangs. The journal of this world contains all
     * frames up to its last complete frame.
     */
    private static void exit(EventPrinter events) {
        System.err.println("reve: a world stands still, and --stalled is exit: ended");
        events.close(LAST_WORDS);
        Runtime.getRuntime().halt(ExitCode.STALLED);
    }

    private AgentServerConfig agents() throws IOException {
        if (!(deadline >= MIN_DEADLINE && deadline <= MAX_DEADLINE)) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--deadline is "
                            + Rounded.of(deadline)
                            + ", expected "
                            + Rounded.of(MIN_DEADLINE)
                            + " to "
                            + Rounded.of(MAX_DEADLINE)
                            + " s");
        }
        AgentServerConfig config =
                listen.config()
                        .withDeadline(Duration.ofNanos(Math.round(deadline * 1e9)))
                        .withWaiting(waiting());
        return audit.plan().map(config::withAudit).orElse(config);
    }

    private Optional<Duration> waiting() {
        if (waiting.equals(NO_LIMIT)) {
            return Optional.empty();
        }
        try {
            double seconds = Double.parseDouble(waiting);
            if (seconds >= MIN_WAITING && seconds <= MAX_WAITING) {
                return Optional.of(Duration.ofNanos(Math.round(seconds * 1e9)));
            }
        } catch (NumberFormatException e) {
            // The exception is ignored, because the message after this block reports the problem.
        }
        throw new ParameterException(
                spec.commandLine(),
                "--waiting is '"
                        + waiting
                        + "'"
                        + ", expected "
                        + NO_LIMIT
                        + " or "
                        + MIN_WAITING
                        + " to "
                        + MAX_WAITING
                        + " s");
    }
}
