// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.jspecify.annotations.Nullable;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;
import picocli.CommandLine.Spec;

import reve.core.file.WorldDescription;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.image.CorruptException;
import reve.core.text.Rounded;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.WorldSnapshot;
import reve.worlds.Product;
import reve.worlds.picture.Ffmpeg;
import reve.worlds.picture.FrameSink;
import reve.worlds.picture.Gif;
import reve.worlds.picture.LayerFiles;
import reve.worlds.picture.Overlay;
import reve.worlds.picture.PictureFolder;
import reve.worlds.render.ImageFormat;
import reve.worlds.render.PixelLayers;
import reve.worlds.render.Renderer;
import reve.worlds.render.Scene;
import reve.worlds.server.History;
import reve.worlds.server.LawPath;
import reve.worlds.server.Simulation;
import reve.worlds.server.StoredRun;

import java.awt.image.BufferedImage;
import java.io.IOException;
import java.io.PrintWriter;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.Callable;

/** The command {@code video}: draws a run as a video. */
@Command(
        name = "video",
        description =
                "Draws a world that runs, a recording or a store as a video: .mp4, .webm and .webp"
                        + " (with the program ffmpeg), .gif, or a folder of PNG files.")
public final class VideoCommand implements Callable<Integer> {
    private static final String GIF = ".gif";
    private static final int MOST_FPS = 120;
    private static final int MOST_GIF_FPS = 50;
    private static final long MOST_PICTURES = 1_000_000;
    private static final double DEFAULT_SECONDS = 10;

    @Spec private CommandSpec spec = CommandSpec.create();

    @Parameters(
            paramLabel = "WORLD|FILE",
            description =
                    "A world file, a folder with a world.yaml, a pack, a recording (--record) or a"
                            + " store (serve --store); with --store URL the name of a world.")
    private Path path = Path.of("");

    @Mixin private SharedWorld shared = new SharedWorld();

    @Mixin private LawOptions laws = new LawOptions();

    @Mixin private PluginOptions plugins = new PluginOptions();

    @Option(
            names = "--out",
            paramLabel = "FILE",
            required = true,
            description = "Video to write; a name without an ending is a folder.")
    private Path out = Path.of("");

    @Option(
            names = "--seconds",
            paramLabel = "S",
            description =
                    "World time to show [s] (default: 10; a recording or a store to its end).")
    private Optional<Double> seconds = Optional.empty();

    @Option(
            names = "--from",
            paramLabel = "S",
            defaultValue = "0",
            description = "Time after the first state at which to begin [s] (default: 0).")
    private double from;

    @Option(
            names = "--fps",
            paramLabel = "N",
            defaultValue = "25",
            description = "Pictures per second of the video (default: ${DEFAULT-VALUE}).")
    private int fps;

    @Option(
            names = "--speed",
            paramLabel = "X",
            defaultValue = "1",
            description =
                    "World time per time of the video: 2 shows a run in half of its time"
                            + " (default: ${DEFAULT-VALUE}).")
    private double speed;

    @Option(
            names = "--size",
            paramLabel = "WxH",
            defaultValue = "960x640",
            converter = SizeConverter.class,
            description = "Width and height [px] (default: ${DEFAULT-VALUE}).")
    private ImageFormat format = ImageFormat.of(960, 640);

    @Option(
            names = "--camera",
            paramLabel = "NAME",
            description = "A camera of the world file's key `cameras` (default: its `camera`).")
    private Optional<String> camera = Optional.empty();

    @Option(
            names = "--world",
            paramLabel = "WORLD",
            description =
                    "World file with the cameras for a recording or a store (default with --store:"
                            + " that of the database).")
    private Optional<Path> cameraWorld = Optional.empty();

    @Option(names = "--labels", description = "Write the names of the visible items.")
    private boolean labels;

    @Option(names = "--time", description = "Write the world time.")
    private boolean time;

    @Option(
            names = "--scale-bar",
            description =
                    "Draw a bar with its length, correct at the distance of the camera's target.")
    private boolean scaleBar;

    @Option(names = "--json", description = "Print the result as one JSON document.")
    private boolean json;

    /** A source of the states that a video shows, in order. */
    private interface Source extends AutoCloseable {
        /** Advances the world to the next frame. Returns false at the end. */
        boolean advance();

        WorldSnapshot snapshot();

        Timing timing();

        /**
         * Returns the fraction of a recording that was read. Returns 0 if the source has no end.
         */
        double part();

        @Override
        void close() throws IOException;
    }

    private record Live(Simulation simulation, Outcome outcome) implements Source {
        @Override
        public boolean advance() {
            simulation.loop().run(1);
            return true;
        }

        @Override
        public WorldSnapshot snapshot() {
            return simulation.snapshots().acquireLatest().orElseThrow();
        }

        @Override
        public Timing timing() {
            return simulation.description().timing();
        }

        @Override
        public double part() {
            return 0;
        }

        @Override
        public void close() {
            simulation.close();
        }
    }

    private record Past(History history) implements Source {
        @Override
        public boolean advance() {
            return history.next();
        }

        @Override
        public WorldSnapshot snapshot() {
            return history.snapshot();
        }

        @Override
        public Timing timing() {
            return history.timing();
        }

        @Override
        public double part() {
            return history.part();
        }

        @Override
        public void close() throws IOException {
            history.close();
        }
    }

    @Override
    public Integer call() throws Exception {
        plugins.use();
        check();
        Optional<Path> ffmpeg = Ffmpeg.isFor(out) ? Optional.of(program()) : Optional.empty();
        Path place = place();
        Optional<SharedWorld.Found> found = shared.find(path);
        boolean isPast = found.isPresent() || StoredRun.isOne(path);
        if (!isPast && cameraWorld.isPresent()) {
            throw wrong("--world: " + path + " is a world itself; leave the option out");
        }
        WorldArgument world =
                found.map(SharedWorld.Found::files).orElseGet(() -> new WorldArgument(path));
        Optional<WorldDescription> description =
                found.isPresent() && cameraWorld.isEmpty()
                        ? Optional.of(world.read())
                        : description(isPast, world);
        Viewpoint viewpoint = Viewpoint.of(spec, camera, description, format);
        try (Source source = isPast ? past(found) : live(description.orElseThrow(), world);
                Renderer renderer =
                        new Renderer(Product.nativeFolder(), Renderer.DEFAULT_DEADLINE);
                FrameSink sink = sink(place, ffmpeg)) {
            Drawn drawn = draw(source, renderer, viewpoint, sink);
            sink.finish();
            Optional<Outcome> outcome =
                    source instanceof Live live ? Optional.of(live.outcome()) : Optional.empty();
            tell(place, drawn, outcome);
            return outcome.map(Outcome::code).orElse(ExitCode.OK);
        }
    }

    private ParameterException wrong(String message) {
        return new ParameterException(spec.commandLine(), message);
    }

    private void check() {
        int most = ending().equals(GIF) ? MOST_GIF_FPS : MOST_FPS;
        if (fps < 1 || fps > most) {
            throw wrong("--fps is " + fps + ", expected 1 to " + most);
        }
        if (!(speed > 0 && speed <= 1e6)) {
            throw wrong(
                    "--speed is " + Rounded.of(speed) + ", expected above 0 and at most 1000000");
        }
        double length = seconds.orElse(DEFAULT_SECONDS);
        if (!(length > 0 && length / speed * fps <= MOST_PICTURES)) {
            throw wrong(
                    "--seconds is "
                            + Rounded.of(length)
                            + ", expected a time above 0 with at most "
                            + MOST_PICTURES
                            + " pictures");
        }
        if (!(from >= 0 && from <= 1e9)) {
            throw wrong("--from is " + Rounded.of(from) + ", expected 0 to 1000000000");
        }
    }

    private String ending() {
        String name = String.valueOf(out.getFileName()).toLowerCase(Locale.ROOT);
        int dot = name.lastIndexOf('.');
        return dot <= 0 ? "" : name.substring(dot);
    }

    private Path program() {
        return Ffmpeg.find()
                .orElseThrow(
                        () ->
                                wrong(
                                        "--out "
                                                + out
                                                + " needs the program ffmpeg, which is not on the"
                                                + " PATH; install it (on Debian: apt-get install"
                                                + " ffmpeg), or name a .gif file or a folder,"
                                                + " which need no other program"));
    }

    /** Returns the path of the video. Creates the folder if the video is a folder of pictures. */
    private Path place() throws IOException {
        if (ending().equals(GIF)) {
            return WritableFile.require(spec, "--out", out, "GIF8", "a GIF");
        }
        if (Ffmpeg.isFor(out)) {
            return WritableFile.require(
                    spec, "--out", out, Ffmpeg.mark(out), "a video of this format");
        }
        if (!ending().isEmpty()) {
            throw wrong(
                    "--out "
                            + out
                            + ": expected a name that ends in .mp4, .webm, .webp or .gif, or a"
                            + " folder");
        }
        OptionFolder.make(spec, "--out", out);
        return out.toAbsolutePath().normalize();
    }

    private FrameSink sink(Path place, Optional<Path> ffmpeg) throws IOException {
        if (ffmpeg.isPresent()) {
            return new Ffmpeg(ffmpeg.get(), place, format.width(), format.height(), fps);
        }
        return Files.isDirectory(place) ? new PictureFolder(place) : new Gif(place, fps);
    }

    private Optional<WorldDescription> description(boolean isPast, WorldArgument world)
            throws Exception {
        if (!isPast) {
            return Optional.of(world.read());
        }
        if (cameraWorld.isEmpty()) {
            if (camera.isPresent()) {
                throw wrong(
                        "--camera: a recording or a store has no cameras; name the world file with"
                                + " --world");
            }
            return Optional.empty();
        }
        return Optional.of(new WorldArgument(cameraWorld.get()).read());
    }

    private Source live(WorldDescription description, WorldArgument world) throws IOException {
        LawPath lawPath = laws.path(spec).forWorld(world.folder());
        Simulation simulation = new Simulation(description, Pacing.FAST, lawPath);
        Outcome outcome = new Outcome(spec, simulation);
        simulation.usePluginListeners();
        simulation.loop().run(0);
        return new Live(simulation, outcome);
    }

    private Source past(Optional<SharedWorld.Found> found) throws IOException {
        LawPath lawPath = laws.path(spec);
        History history =
                new History(
                        found.isPresent()
                                ? found.get().open(lawPath)
                                : StoredRun.open(path, lawPath));
        try {
            if (history.next()) {
                return new Past(history);
            }
        } catch (RuntimeException e) {
            history.close();
            throw e;
        }
        history.close();
        throw new CorruptException(
                path + " ends before the first image of the world: there is nothing to show");
    }

    /** The number of pictures, and the time of the last one [s]. */
    private record Drawn(long pictures, double time) {}

    private Drawn draw(Source source, Renderer renderer, Viewpoint viewpoint, FrameSink sink)
            throws IOException {
        @Nullable Overlay overlay =
                labels || time || scaleBar ? new Overlay(format.height()) : null;
        boolean toItsEnd = source instanceof Past && seconds.isEmpty();
        long wanted =
                toItsEnd
                        ? MOST_PICTURES
                        : Math.max(1, Math.round(seconds.orElse(DEFAULT_SECONDS) / speed * fps));
        double rate = source.timing().framesPerSecond();
        Progress progress = new Progress(System.err, 0);
        long frame = 0;
        double last = 0;
        for (long picture = 0; picture < wanted; picture++) {
            long next = Math.round((from + picture * speed / fps) * rate);
            for (; frame < next; frame++) {
                if (!source.advance()) {
                    progress.done();
                    return ended(picture, last);
                }
            }
            last = draw(source, renderer, viewpoint, overlay, sink);
            progress.at(
                    "picture " + (picture + 1) + (toItsEnd ? "" : " of " + wanted),
                    toItsEnd ? source.part() : (picture + 1.0) / wanted);
        }
        progress.done();
        return new Drawn(wanted, last);
    }

    private Drawn ended(long pictures, double last) {
        if (pictures == 0) {
            throw new CorruptException(
                    path
                            + " ends before --from "
                            + Rounded.of(from)
                            + " s: there is nothing to show");
        }
        return new Drawn(pictures, last);
    }

    /** Draws the current state, and returns its time [s]. */
    private double draw(
            Source source,
            Renderer renderer,
            Viewpoint viewpoint,
            @Nullable Overlay overlay,
            FrameSink sink)
            throws IOException {
        try (WorldSnapshot snapshot = source.snapshot()) {
            Map<ItemId, ItemSymbols> items = snapshot.symbols();
            Scene scene = viewpoint.scene(snapshot);
            PixelLayers layers =
                    renderer.pixels(scene, PixelLayers.COLOUR | (labels ? PixelLayers.ITEM : 0));
            BufferedImage picture = LayerFiles.colour(layers);
            if (overlay != null && labels) {
                overlay.labels(picture, layers, id -> items.get(new ItemId(id)).name());
            }
            if (overlay != null && time) {
                overlay.time(picture, snapshot.timeSeconds());
            }
            if (overlay != null && scaleBar) {
                overlay.scale(picture, scene.camera().metresPerPixel(scene.image().height()));
            }
            sink.add(picture);
            return snapshot.timeSeconds();
        }
    }

    private void tell(Path place, Drawn drawn, Optional<Outcome> outcome) {
        if (json) {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("file", place.toString());
            fields.put("pictures", drawn.pictures());
            fields.put("fps", fps);
            fields.put("time", drawn.time());
            fields.put("width", format.width());
            fields.put("height", format.height());
            outcome.ifPresent(known -> known.addTo(fields));
            Json.print(spec, fields);
            return;
        }
        PrintWriter printer = spec.commandLine().getOut();
        printer.println(place);
        printer.flush();
    }
}
