package reve.worlds.cli;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.concurrent.Callable;
import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;
import reve.core.agent.AgentServerConfig;
import reve.core.file.WorldDescription;
import reve.core.frame.Pacing;
import reve.worlds.journal.SqliteStore;
import reve.worlds.server.Persistence;
import reve.worlds.server.Pictures;
import reve.worlds.server.ServerReport;
import reve.worlds.server.WorldServer;

/** Runs a world that agents can join and laws can be dropped into, until Ctrl-C. */
@Command(
        name = "serve",
        description = "Runs a world that agents can join and laws can be dropped into, until Ctrl-C.")
public final class ServeCommand implements Callable<Integer> {
    @Spec
    private CommandSpec spec = CommandSpec.create();

    @Mixin
    private WorldArgument world = new WorldArgument();

    @Mixin
    private ListenOptions listen = new ListenOptions();

    @Option(names = "--laws", paramLabel = "DIR",
            description = "Folder to watch: law libraries dropped here act, removed ones stop.")
    private Optional<Path> laws = Optional.empty();

    @Option(names = "--seconds", paramLabel = "S", description = "Stop after this much world time [s].")
    private Optional<Double> seconds = Optional.empty();

    @Option(names = "--snapshots", paramLabel = "DIR", defaultValue = ".",
            description = "Folder for pictures, made if missing (default: the current one).")
    private Path snapshots = Path.of(".");

    @Option(names = "--snapshot-at", paramLabel = "S", split = ",",
            description = "World times to take pictures at [s], for example 0,2.5,5.")
    private List<Double> snapshotAt = new ArrayList<>();

    @Option(names = "--store", paramLabel = "FILE",
            description = "Keep the world in this file, and go on with what it holds.")
    private Optional<Path> store = Optional.empty();

    @Option(names = "--store-every", paramLabel = "S", defaultValue = "10",
            description = "World time between whole images in the store [s] (default: ${DEFAULT-VALUE}).")
    private double storeEvery;

    @Option(names = "--durability", paramLabel = "KIND", defaultValue = "normal",
            description = "What the store survives: normal, the end of the process; full, of power too.")
    private SqliteStore.Durability durability = SqliteStore.Durability.NORMAL;

    @Option(names = "--record", paramLabel = "FILE",
            description = "Record the run, for ./reve replay.")
    private Optional<Path> record = Optional.empty();

    @Option(names = "--audit", paramLabel = "FILE",
            description = "Append what each client is told, and when, as one JSON object per message.")
    private Optional<Path> audit = Optional.empty();

    @Option(names = "--fast", description = "As fast as it goes, instead of paced to the wall clock.")
    private boolean fast;

    @Option(names = "--json", description = "Report events as one JSON object per line on standard output.")
    private boolean json;

    @Override
    public Integer call() throws Exception {
        AgentServerConfig agents = agents();
        WorldDescription description = world.load();
        long frames = Frames.of(spec, "--seconds", seconds, description.timing());
        List<Long> pictureFrames = new ArrayList<>();
        for (double time : snapshotAt) {
            pictureFrames.add(Frames.of(spec, "--snapshot-at", time, description.timing()));
        }
        if (!pictureFrames.isEmpty()) {
            Files.createDirectories(snapshots);
        }
        Pictures pictures = new Pictures(snapshots, pictureFrames);
        try (EventPrinter events = new EventPrinter(spec.commandLine().getOut(), json)) {
            WorldServer server = new WorldServer(description, fast ? Pacing.FAST : Pacing.REAL_TIME,
                    agents, laws, persistence(), pictures, events);
            try (Interrupt _ = new Interrupt(server::stop)) {
                ServerReport report;
                try (server) {
                    server.start();
                    report = server.run(frames);
                }
                events.end(report);
            }
        }
        return ExitCode.OK;
    }

    private Persistence persistence() {
        if (!(storeEvery > 0)) {
            throw new ParameterException(spec.commandLine(),
                    "--store-every is " + storeEvery + ", expected a time above 0 s");
        }
        return new Persistence(world.folder(), record, store, storeEvery, durability);
    }

    private AgentServerConfig agents() throws IOException {
        AgentServerConfig config = listen.config();
        return audit.map(config::withAudit).orElse(config);
    }
}
