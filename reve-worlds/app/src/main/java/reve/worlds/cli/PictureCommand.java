// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.jspecify.annotations.Nullable;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFileException;
import reve.core.frame.Pacing;
import reve.core.image.CorruptException;
import reve.core.text.Rounded;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.WorldSnapshot;
import reve.worlds.Product;
import reve.worlds.picture.LayerFiles;
import reve.worlds.picture.Overlay;
import reve.worlds.render.ImageFormat;
import reve.worlds.render.PixelLayers;
import reve.worlds.render.Renderer;
import reve.worlds.render.Scene;
import reve.worlds.server.History;
import reve.worlds.server.LawPath;
import reve.worlds.server.Pictures;
import reve.worlds.server.Simulation;

import java.awt.Graphics2D;
import java.awt.image.BufferedImage;
import java.io.IOException;
import java.io.PrintWriter;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.Callable;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/** The command {@code picture}: runs a world up to a time and takes a picture of it. */
@Command(
        name = "picture",
        description =
                "Runs a world, or repeats a world of a database, up to a time and writes a picture"
                        + " of it, off-screen.")
public final class PictureCommand implements Callable<Integer> {
    private static final Pattern GRID = Pattern.compile("([1-9]\\d?)x([1-9]\\d?)");
    private static final ImageFormat SHEET_FORMAT = ImageFormat.of(480, 320);
    private static final long MOST_PIXELS = 1L << 26;

    @Spec private CommandSpec spec = CommandSpec.create();

    @Mixin private WorldArgument world = new WorldArgument();

    @Mixin private SharedWorld shared = new SharedWorld();

    @Mixin private LawOptions laws = new LawOptions();

    @Mixin private PluginOptions plugins = new PluginOptions();

    @Option(
            names = "--at",
            paramLabel = "S",
            description =
                    "World time of the picture, or of the last picture of a sheet [s]; with --store"
                            + " the time after the first state of the database (default: 0; with"
                            + " --store the newest state).")
    private Optional<Double> at = Optional.empty();

    @Option(
            names = "--out",
            paramLabel = "FILE",
            required = true,
            description = "PNG file to write.")
    private Path out = Path.of("");

    @Option(
            names = "--size",
            paramLabel = "WxH",
            converter = SizeConverter.class,
            description =
                    "Width and height of a picture [px] (default: 960x640; in a sheet 480x320).")
    private Optional<ImageFormat> size = Optional.empty();

    @Option(
            names = "--camera",
            paramLabel = "NAME",
            description = "A camera of the world file's key `cameras` (default: its `camera`).")
    private Optional<String> camera = Optional.empty();

    @Option(names = "--labels", description = "Write the names of the visible items.")
    private boolean labels;

    @Option(
            names = "--scale-bar",
            description =
                    "Draw a bar with its length, correct at the distance of the camera's target.")
    private boolean scaleBar;

    @Option(
            names = "--sheet",
            paramLabel = "CxR",
            description =
                    "Draw a contact sheet of C columns and R rows: pictures at equal times from 0"
                            + " to --at.")
    private Optional<String> sheet = Optional.empty();

    @Option(
            names = "--depth",
            paramLabel = "FILE",
            description =
                    "Also write the distances of the surfaces: .png (16-bit grey) or .npy (f32 in"
                            + " metres).")
    private Optional<Path> depth = Optional.empty();

    @Option(
            names = "--segmentation",
            paramLabel = "FILE",
            description =
                    "Also write which item each pixel shows: .png (a colour for each item) or .npy"
                            + " (u32, ids).")
    private Optional<Path> segmentation = Optional.empty();

    @Option(names = "--json", description = "Print the result as one JSON document.")
    private boolean json;

    private final Map<String, Object> told = new LinkedHashMap<>();

    @Override
    public Integer call() throws Exception {
        plugins.use();
        Path file = WritableFile.require(spec, "--out", out, "PNG\r\n", "a PNG picture");
        if (!out.toString().toLowerCase(Locale.ROOT).endsWith(".png")) {
            throw wrong("--out " + out + ": pictures are PNG, expected a name that ends in .png");
        }
        depth = layerFile("--depth", depth);
        segmentation = layerFile("--segmentation", segmentation);
        int columns = 0;
        int rows = 0;
        if (sheet.isPresent()) {
            Matcher grid = GRID.matcher(sheet.get());
            if (!grid.matches()) {
                throw wrong(
                        "--sheet: '"
                                + sheet.get()
                                + "' is no grid, expected e.g. 3x2 (columns and"
                                + " rows, up to 99)");
            }
            columns = Integer.parseInt(grid.group(1));
            rows = Integer.parseInt(grid.group(2));
            checkSheet(columns, rows);
        }
        Optional<SharedWorld.Found> found = shared.find(world.given());
        if (found.isPresent()) {
            drawPast(found.get(), file);
            return ExitCode.OK;
        }
        LawPath lawPath = laws.path(spec).forWorld(world.folder());
        WorldDescription description = world.read();
        Viewpoint viewpoint = Viewpoint.of(spec, camera, Optional.of(description), format());
        long frames = Frames.of(spec, "--at", at.orElse(0.0), description.timing());
        try (Simulation simulation = new Simulation(description, Pacing.FAST, lawPath);
                Renderer renderer =
                        new Renderer(Product.nativeFolder(), Renderer.DEFAULT_DEADLINE)) {
            Outcome outcome = new Outcome(spec, simulation);
            simulation.usePluginListeners();
            Progress progress = new Progress(System.err, frames);
            simulation.onPublish(
                    "progress", event -> progress.at(event.frame(), event.timeSeconds()));
            if (sheet.isPresent()) {
                drawSheet(simulation, renderer, viewpoint, columns, rows, frames, file);
            } else {
                simulation.loop().run(frames);
                draw(State.of(simulation, viewpoint), renderer, file);
            }
            progress.done();
            outcome.addTo(told);
            tell(file);
            return outcome.code();
        }
    }

    private ParameterException wrong(String message) {
        return new ParameterException(spec.commandLine(), message);
    }

    private ImageFormat format() {
        return size.orElse(sheet.isPresent() ? SHEET_FORMAT : Pictures.DEFAULT_FORMAT);
    }

    private Optional<Path> layerFile(String option, Optional<Path> given) throws IOException {
        if (given.isEmpty()) {
            return given;
        }
        String name = given.get().toString().toLowerCase(Locale.ROOT);
        if (name.endsWith(LayerFiles.NUMPY)) {
            return Optional.of(
                    WritableFile.require(spec, option, given.get(), "NUMPY", "a NumPy file"));
        }
        if (!name.endsWith(LayerFiles.PNG)) {
            throw wrong(option + " " + given.get() + ": expected a name that ends in .png or .npy");
        }
        return Optional.of(
                WritableFile.require(spec, option, given.get(), "PNG\r\n", "a PNG picture"));
    }

    private void checkSheet(int columns, int rows) {
        if (depth.isPresent() || segmentation.isPresent()) {
            throw wrong("--depth and --segmentation are of one picture; leave out --sheet");
        }
        if (columns * rows < 2 || !(at.orElse(0.0) > 0)) {
            throw wrong(
                    "--sheet shows at least two times, expected --at above 0 and two pictures or"
                            + " more");
        }
        long pixels = (long) columns * rows * format().width() * format().height();
        if (pixels > MOST_PIXELS) {
            throw wrong(
                    "--sheet: "
                            + pixels
                            + " pixels, expected at most "
                            + MOST_PIXELS
                            + "; choose a smaller --size or fewer pictures");
        }
    }

    /** The state of a world that is drawn: its scene, its time, and the names of its items. */
    private record State(Scene scene, double time, Map<ItemId, ItemSymbols> items) {
        static State of(Simulation simulation, Viewpoint viewpoint) {
            try (WorldSnapshot snapshot = simulation.snapshots().acquireLatest().orElseThrow()) {
                return of(snapshot, viewpoint);
            }
        }

        static State of(WorldSnapshot snapshot, Viewpoint viewpoint) {
            return new State(viewpoint.scene(snapshot), snapshot.timeSeconds(), snapshot.symbols());
        }

        double metresPerPixel() {
            return scene.camera().metresPerPixel(scene.image().height());
        }

        String name(long id) {
            ItemSymbols item = items.get(new ItemId(id));
            return item == null ? "" : item.name();
        }
    }

    /** Draws a state that a database contains. */
    private void drawPast(SharedWorld.Found found, Path file)
            throws IOException, WorldFileException {
        if (sheet.isPresent()) {
            throw wrong(
                    "--sheet runs a world from its beginning, and --store names frames that were"
                            + " made; draw these with the command video");
        }
        Viewpoint viewpoint =
                Viewpoint.of(spec, camera, Optional.of(found.files().read()), format());
        try (History history = new History(found.open(laws.path(spec)));
                Renderer renderer =
                        new Renderer(Product.nativeFolder(), Renderer.DEFAULT_DEADLINE)) {
            if (!history.next()) {
                throw new CorruptException(
                        found.address() + " has made no frame: there is nothing to show");
            }
            long first = history.frame();
            long wanted = Frames.of(spec, "--at", at, history.timing());
            Progress progress = new Progress(System.err, 0);
            while (history.frame() - first < wanted && history.next()) {
                progress.at("frame " + history.frame(), history.part());
            }
            progress.done();
            if (at.isPresent() && history.frame() - first < wanted) {
                throw wrong(
                        "--at is "
                                + Rounded.of(at.get())
                                + ", but "
                                + found.address()
                                + " ends "
                                + Rounded.of(
                                        (double) (history.frame() - first)
                                                / history.timing().framesPerSecond())
                                + " s after its first state");
            }
            try (WorldSnapshot snapshot = history.snapshot()) {
                told.put("frame", snapshot.frame());
                draw(State.of(snapshot, viewpoint), renderer, file);
            }
        }
        tell(file);
    }

    private void draw(State state, Renderer renderer, Path file) throws IOException {
        told.put("time", state.time());
        int wanted =
                (labels || scaleBar ? PixelLayers.COLOUR : 0)
                        | (labels ? PixelLayers.ITEM : 0)
                        | (depth.isPresent() ? PixelLayers.DEPTH : 0)
                        | (segmentation.isPresent() ? PixelLayers.ITEM : 0);
        @Nullable PixelLayers layers = wanted == 0 ? null : renderer.pixels(state.scene(), wanted);
        if ((labels || scaleBar) && layers != null) {
            BufferedImage picture = LayerFiles.colour(layers);
            var overlay = new Overlay(picture.getHeight());
            if (labels) {
                overlay.labels(picture, layers, state::name);
            }
            if (scaleBar) {
                told.put("scaleBar", overlay.scale(picture, state.metresPerPixel()));
            }
            LayerFiles.writePng(picture, file);
        } else {
            renderer.render(state.scene(), file);
        }
        if (depth.isPresent() && layers != null) {
            told.put("depth", depth.get().toString());
            told.put("depthStep", LayerFiles.writeDepth(layers, depth.get()));
        }
        if (segmentation.isPresent() && layers != null) {
            told.put("segmentation", segmentation.get().toString());
            List<Map<String, Object>> items = new ArrayList<>();
            LayerFiles.writeSegmentation(layers, segmentation.get())
                    .forEach(
                            (id, colour) -> {
                                Map<String, Object> item = new LinkedHashMap<>();
                                item.put("id", id);
                                item.put("name", state.name(id));
                                item.put("colour", colour);
                                items.add(item);
                            });
            told.put("items", items);
        }
    }

    private void drawSheet(
            Simulation simulation,
            Renderer renderer,
            Viewpoint viewpoint,
            int columns,
            int rows,
            long frames,
            Path file)
            throws IOException {
        ImageFormat cell = format();
        var all =
                new BufferedImage(
                        columns * cell.width(), rows * cell.height(), BufferedImage.TYPE_INT_RGB);
        Graphics2D paper = all.createGraphics();
        var overlay = new Overlay(cell.height());
        int count = columns * rows;
        List<Double> times = new ArrayList<>();
        for (int i = 0; i < count; i++) {
            long frame = Math.round((double) frames * i / (count - 1));
            simulation.loop().run(frame - simulation.loop().frame());
            State state = State.of(simulation, viewpoint);
            PixelLayers layers =
                    renderer.pixels(
                            state.scene(), PixelLayers.COLOUR | (labels ? PixelLayers.ITEM : 0));
            BufferedImage picture = LayerFiles.colour(layers);
            if (labels) {
                overlay.labels(picture, layers, state::name);
            }
            overlay.time(picture, state.time());
            if (scaleBar) {
                overlay.scale(picture, state.metresPerPixel());
            }
            paper.drawImage(picture, i % columns * cell.width(), i / columns * cell.height(), null);
            times.add(state.time());
        }
        paper.dispose();
        LayerFiles.writePng(all, file);
        told.put("times", times);
        told.put("columns", columns);
        told.put("rows", rows);
    }

    private void tell(Path file) {
        if (json) {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("file", file.toString());
            fields.putAll(told);
            fields.put("width", format().width());
            fields.put("height", format().height());
            Json.print(spec, fields);
            return;
        }
        PrintWriter printer = spec.commandLine().getOut();
        printer.println(file);
        depth.ifPresent(
                path ->
                        printer.println(
                                told.get("depthStep").equals(1.0)
                                        ? path + ", in m"
                                        : path
                                                + ", in steps of "
                                                + Shortened.of(told.get("depthStep"))
                                                + " m"));
        segmentation.ifPresent(printer::println);
        printer.flush();
    }
}
