// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;
import picocli.CommandLine.Spec;

import reve.core.disk.WholeFile;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFileException;
import reve.core.frame.Pacing;
import reve.core.image.CorruptException;
import reve.core.text.Rounded;
import reve.core.world.WorldSnapshot;
import reve.worlds.Product;
import reve.worlds.export.CsvExport;
import reve.worlds.export.Export;
import reve.worlds.export.ExportedFrame;
import reve.worlds.export.McapExport;
import reve.worlds.export.OntologyExport;
import reve.worlds.render.ImageFormat;
import reve.worlds.render.Renderer;
import reve.worlds.server.History;
import reve.worlds.server.LawPath;
import reve.worlds.server.Simulation;
import reve.worlds.server.StoredRun;

import java.io.IOException;
import java.io.PrintWriter;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.concurrent.Callable;

/**
 * The command {@code export}: writes the frames of a recording or a store for other programs, or
 * one state of a world for reasoners.
 */
@Command(
        name = "export",
        description =
                "Repeats a recording or a store, and writes its frames as tables (CSV) or as an"
                        + " MCAP file. Also writes a state, also of a world that runs, as an OWL"
                        + " ontology (JSON-LD).")
public final class ExportCommand implements Callable<Integer> {
    @Spec private CommandSpec spec = CommandSpec.create();

    @Parameters(
            paramLabel = "FILE|WORLD",
            description =
                    "Recording that --record wrote, or store that serve --store wrote; for"
                            + " --json-ld also a world file, a folder with a world.yaml, or a pack;"
                            + " with --store URL the name of a world.")
    private Path file = Path.of("");

    @Mixin private SharedWorld shared = new SharedWorld();

    /** The world of the database; empty without {@code --store}. */
    private Optional<SharedWorld.Found> found = Optional.empty();

    @Mixin private LawOptions laws = new LawOptions();

    @Mixin private PluginOptions plugins = new PluginOptions();

    @Option(
            names = "--csv",
            paramLabel = "DIR",
            description = "Folder for tables: one for each kind of items, and one of events.")
    private Optional<Path> csv = Optional.empty();

    @Option(
            names = "--mcap",
            paramLabel = "FILE",
            description = "MCAP file for Foxglove and other programs.")
    private Optional<Path> mcap = Optional.empty();

    @Option(
            names = "--json-ld",
            paramLabel = "FILE",
            description = "JSON-LD file: one state as an OWL ontology.")
    private Optional<Path> jsonLd = Optional.empty();

    @Option(
            names = "--at",
            paramLabel = "S",
            description =
                    "Time after the first state of the state that --json-ld writes [s] (default: 0;"
                            + " of a recording or a store the end).")
    private Optional<Double> at = Optional.empty();

    @Option(
            names = "--relations",
            description = "Also write the relations near, on, inside and touching with --json-ld.")
    private boolean relations;

    @Option(
            names = "--kinds",
            paramLabel = "KIND,KIND,...",
            split = ",",
            description = "Kinds whose properties are written (default: all).")
    private Set<String> kinds = new LinkedHashSet<>();

    @Option(
            names = "--every",
            paramLabel = "N",
            defaultValue = "1",
            description = "Write each N-th frame of the world, and all events (default: all).")
    private int every;

    @Option(
            names = "--pictures",
            paramLabel = "S",
            description =
                    "Also draw a picture each S seconds of world time into the MCAP file (default:"
                            + " none).")
    private Optional<Double> pictures = Optional.empty();

    @Option(
            names = "--size",
            paramLabel = "WxH",
            defaultValue = "960x640",
            converter = SizeConverter.class,
            description = "Width and height of the pictures [px] (default: ${DEFAULT-VALUE}).")
    private ImageFormat format = ImageFormat.of(960, 640);

    @Option(
            names = "--world",
            paramLabel = "WORLD",
            description =
                    "World file with the camera of the pictures (default: the whole scene; with"
                            + " --store that of the database).")
    private Optional<Path> cameraWorld = Optional.empty();

    @Option(
            names = "--camera",
            paramLabel = "NAME",
            description =
                    "A camera of the key `cameras` in that world file (default: its `camera`).")
    private Optional<String> camera = Optional.empty();

    @Option(names = "--json", description = "Print the result as one JSON document.")
    private boolean json;

    @Override
    public Integer call() throws Exception {
        plugins.use();
        if (csv.isEmpty() && mcap.isEmpty() && jsonLd.isEmpty()) {
            throw wrong("nothing to write; expected --csv DIR, --mcap FILE or --json-ld FILE");
        }
        if (jsonLd.isEmpty() && (at.isPresent() || relations)) {
            throw wrong("--at and --relations are for --json-ld FILE, which is missing");
        }
        if (every < 1) {
            throw wrong("--every is " + every + ", expected 1 or more");
        }
        if (pictures.isPresent() && (mcap.isEmpty() || !(pictures.get() > 0))) {
            throw wrong(
                    "--pictures is "
                            + Rounded.of(pictures.get())
                            + ", expected a time above 0, beside --mcap FILE");
        }
        if (pictures.isEmpty() && (camera.isPresent() || cameraWorld.isPresent())) {
            throw wrong("--camera and --world are for pictures; expected --pictures S");
        }
        found = shared.find(file);
        if (camera.isPresent() && cameraWorld.isEmpty() && found.isEmpty()) {
            throw wrong("--camera: expected the world file that has the camera, --world WORLD");
        }
        if (mcap.isPresent()) {
            mcap =
                    Optional.of(
                            WritableFile.require(
                                    spec, "--mcap", mcap.get(), McapExport.MARK, "an MCAP file"));
        }
        if (jsonLd.isPresent()) {
            jsonLd =
                    Optional.of(
                            WritableFile.require(
                                    spec,
                                    "--json-ld",
                                    jsonLd.get(),
                                    OntologyExport.MARK,
                                    "a JSON-LD file"));
            if (found.isEmpty() && !StoredRun.isOne(file)) {
                return writeWorld(jsonLd.get());
            }
        }
        LawPath lawPath = laws.path(spec);
        try (History history =
                new History(
                        found.isPresent()
                                ? found.get().open(lawPath)
                                : StoredRun.open(file, lawPath))) {
            if (!history.next()) {
                throw new CorruptException(
                        file
                                + " ends before the first image of the world: there is nothing to"
                                + " export");
            }
            return write(history);
        }
    }

    /** Runs a world up to the time of the state, and writes this state. */
    private int writeWorld(Path to) throws IOException, WorldFileException {
        if (csv.isPresent() || mcap.isPresent()) {
            throw wrong(
                    "--csv and --mcap write the frames of a recording or a store, which "
                            + file
                            + " is not");
        }
        WorldArgument world = new WorldArgument(file);
        LawPath lawPath = laws.path(spec).forWorld(world.folder());
        WorldDescription description = world.read();
        long frames = Frames.of(spec, "--at", at.orElse(0.0), description.timing());
        try (Simulation simulation = new Simulation(description, Pacing.FAST, lawPath)) {
            Outcome outcome = new Outcome(spec, simulation);
            simulation.usePluginListeners();
            Progress progress = new Progress(System.err, frames);
            simulation.onPublish(
                    "progress", event -> progress.at(event.frame(), event.timeSeconds()));
            simulation.loop().run(frames);
            progress.done();
            try (WorldSnapshot snapshot = simulation.snapshots().acquireLatest().orElseThrow()) {
                WholeFile.write(
                        to,
                        out ->
                                OntologyExport.write(
                                        out,
                                        description.name(),
                                        description.doc(),
                                        description.prototype(),
                                        snapshot,
                                        relations));
                tell(1, snapshot.frame(), false, List.of(to), Optional.of(outcome));
            }
            return outcome.code();
        }
    }

    private ParameterException wrong(String message) {
        return new ParameterException(spec.commandLine(), message);
    }

    /** Draws pictures into an MCAP file. */
    private final class Drawing implements AutoCloseable {
        private final Renderer renderer =
                new Renderer(Product.nativeFolder(), Renderer.DEFAULT_DEADLINE);
        private final Viewpoint viewpoint;
        private final McapExport file;
        private final double frames;
        private long drawn;

        Drawing(Viewpoint viewpoint, McapExport file, double frames) {
            this.viewpoint = viewpoint;
            this.file = file;
            this.frames = frames;
        }

        /** Draws a state of the world if the next picture is due. */
        void draw(WorldSnapshot snapshot, long sinceFirst) throws IOException {
            if (sinceFirst >= Math.round(drawn * frames)) {
                drawn = (long) Math.floor(sinceFirst / frames) + 1;
                file.addPicture(snapshot.frame(), renderer.render(viewpoint.scene(snapshot)));
            }
        }

        @Override
        public void close() {
            renderer.close();
        }
    }

    private Viewpoint viewpoint() throws IOException, WorldFileException {
        Optional<WorldArgument> world =
                cameraWorld.map(WorldArgument::new).or(() -> found.map(SharedWorld.Found::files));
        Optional<WorldDescription> description =
                world.isEmpty() || pictures.isEmpty()
                        ? Optional.empty()
                        : Optional.of(world.get().read());
        return Viewpoint.of(spec, camera, description, format);
    }

    private int write(History history) throws IOException, WorldFileException {
        Viewpoint viewpoint = viewpoint();
        Set<String> wanted = kinds(history);
        List<Path> written = new ArrayList<>();
        List<Export> exports = new ArrayList<>();
        Optional<Drawing> drawing = Optional.empty();
        long frames;
        try {
            if (csv.isPresent()) {
                OptionFolder.make(spec, "--csv", csv.get());
                for (Path table : CsvExport.files(csv.get(), wanted)) {
                    written.add(
                            WritableFile.require(
                                    spec, "--csv", table, CsvExport.MARK, "a table of export"));
                }
                exports.add(new CsvExport(csv.get(), wanted));
            }
            if (mcap.isPresent()) {
                written.add(mcap.get());
                McapExport export =
                        new McapExport(
                                mcap.get(),
                                history.world(),
                                history.prototype(),
                                history.timing(),
                                wanted);
                exports.add(export);
                double rate = history.timing().framesPerSecond();
                drawing = pictures.map(s -> new Drawing(viewpoint, export, s * rate));
            }
            jsonLd.ifPresent(written::add);
            frames = write(history, exports, drawing);
            for (Export export : exports) {
                export.finish();
            }
        } finally {
            drawing.ifPresent(Drawing::close);
            for (Export export : exports) {
                export.close();
            }
        }
        tell(frames, history.frame(), history.wasCut(), written, Optional.empty());
        return ExitCode.OK;
    }

    private Set<String> kinds(History history) {
        List<String> all = history.prototype().kinds();
        for (String kind : kinds) {
            if (!all.contains(kind)) {
                throw wrong(
                        "--kinds: the world has no kind \""
                                + kind
                                + "\"; its kinds are "
                                + String.join(", ", all));
            }
        }
        return kinds.isEmpty() ? new LinkedHashSet<>(all) : kinds;
    }

    /** Passes the frames to the exports. Returns the number of frames. */
    private long write(History history, List<Export> exports, Optional<Drawing> drawing)
            throws IOException {
        Progress progress = new Progress(System.err, 0);
        long first = history.frame();
        long wanted = Frames.of(spec, "--at", at, history.timing());
        boolean isWritten = jsonLd.isEmpty();
        long frames = 0;
        List<ExportedFrame.Event> events = new ArrayList<>();
        do {
            history.happenings()
                    .forEach(
                            each ->
                                    events.add(
                                            new ExportedFrame.Event(each.type(), each.fields())));
            if ((history.frame() - first) % every == 0) {
                try (WorldSnapshot snapshot = history.snapshot()) {
                    ExportedFrame frame = new ExportedFrame(snapshot, List.copyOf(events));
                    for (Export export : exports) {
                        export.add(frame);
                    }
                    if (drawing.isPresent()) {
                        drawing.get().draw(snapshot, history.frame() - first);
                    }
                }
                events.clear();
                frames++;
            }
            progress.at("frame " + history.frame(), history.part());
            if (!isWritten && history.frame() - first >= wanted) {
                writeOntology(history);
                isWritten = true;
            }
        } while (history.next());
        progress.done();
        if (!isWritten && at.isPresent()) {
            throw wrong(
                    "--at is "
                            + Rounded.of(at.get())
                            + ", but "
                            + file
                            + " ends "
                            + Rounded.of(
                                    (double) (history.frame() - first)
                                            / history.timing().framesPerSecond())
                            + " s after its first state");
        }
        if (!isWritten) {
            writeOntology(history);
        }
        return frames;
    }

    private void writeOntology(History history) throws IOException {
        try (WorldSnapshot snapshot = history.snapshot()) {
            WholeFile.write(
                    jsonLd.orElseThrow(),
                    out ->
                            OntologyExport.write(
                                    out,
                                    history.world(),
                                    "",
                                    history.prototype(),
                                    snapshot,
                                    relations));
        }
    }

    private void tell(
            long frames,
            long frame,
            boolean wasCut,
            List<Path> written,
            Optional<Outcome> outcome) {
        if (json) {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("frames", frames);
            fields.put("frame", frame);
            fields.put("cut", wasCut);
            fields.put("files", written.stream().map(Path::toString).toList());
            outcome.ifPresent(known -> known.addTo(fields));
            Json.print(spec, fields);
            return;
        }
        PrintWriter out = spec.commandLine().getOut();
        if (wasCut) {
            out.println("the recording ends in the middle of a record, as after a crash");
        }
        out.println(frames + (frames == 1 ? " frame" : " frames") + ", up to frame " + frame);
        written.forEach(out::println);
        out.flush();
    }
}
