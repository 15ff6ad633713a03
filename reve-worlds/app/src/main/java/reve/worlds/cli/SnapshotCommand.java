// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.ITypeConverter;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;
import picocli.CommandLine.TypeConversionException;

import reve.core.file.WorldDescription;
import reve.core.frame.Pacing;
import reve.core.world.WorldSnapshot;
import reve.worlds.Product;
import reve.worlds.render.ImageFormat;
import reve.worlds.render.Renderer;
import reve.worlds.render.Scene;
import reve.worlds.server.LawPath;
import reve.worlds.server.Pictures;
import reve.worlds.server.Simulation;

import java.io.PrintWriter;
import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.Locale;
import java.util.Map;
import java.util.concurrent.Callable;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/** The command {@code snapshot}: runs a world up to a time and takes a picture of it. */
@Command(
        name = "snapshot",
        description = "Runs a world up to a time and writes a picture of it, off-screen.")
public final class SnapshotCommand implements Callable<Integer> {
    @Spec private CommandSpec spec = CommandSpec.create();

    @Mixin private WorldArgument world = new WorldArgument();

    @Mixin private LawOptions laws = new LawOptions();

    @Option(
            names = "--at",
            paramLabel = "S",
            defaultValue = "0",
            description = "World time of the picture [s] (default: ${DEFAULT-VALUE}).")
    private double at;

    @Option(
            names = "--out",
            paramLabel = "FILE",
            required = true,
            description = "PNG file to write.")
    private Path out = Path.of("");

    @Option(
            names = "--size",
            paramLabel = "WxH",
            defaultValue = "960x640",
            converter = SizeConverter.class,
            description = "Width and height [px] (default: ${DEFAULT-VALUE}).")
    private ImageFormat format = Pictures.DEFAULT_FORMAT;

    @Option(names = "--json", description = "Print the result as one JSON document.")
    private boolean json;

    @Override
    public Integer call() throws Exception {
        Path file = WritableFile.require(spec, "--out", out, "PNG\r\n", "a PNG picture");
        if (!out.toString().toLowerCase(Locale.ROOT).endsWith(".png")) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--out " + out + ": pictures are PNG, expected a name that ends in .png");
        }
        LawPath lawPath = laws.path(spec).forWorld(world.folder());
        WorldDescription description = world.load(spec.commandLine().getErr());
        long frames = Frames.of(spec, "--at", at, description.timing());
        try (Simulation simulation = new Simulation(description, Pacing.FAST, lawPath);
                Renderer renderer =
                        new Renderer(Product.nativeFolder(), Renderer.DEFAULT_DEADLINE)) {
            Progress progress = new Progress(System.err, frames);
            simulation.onPublish(
                    "progress", event -> progress.at(event.frame(), event.timeSeconds()));
            simulation.loop().run(frames);
            progress.done();
            double time;
            Scene scene;
            try (WorldSnapshot snapshot = simulation.snapshots().acquireLatest().orElseThrow()) {
                time = snapshot.timeSeconds();
                scene = Pictures.sceneBuilder(simulation, format).build(snapshot);
            }
            renderer.render(scene, file);
            tell(file, time);
            return ExitCode.OK;
        }
    }

    private void tell(Path file, double time) {
        if (json) {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("file", file.toString());
            fields.put("time", time);
            fields.put("width", format.width());
            fields.put("height", format.height());
            Json.print(spec, fields);
        } else {
            PrintWriter printer = spec.commandLine().getOut();
            printer.println(file);
            printer.flush();
        }
    }

    /** A converter of a text such as {@code 960x640} to a picture format. */
    static final class SizeConverter implements ITypeConverter<ImageFormat> {
        private static final Pattern SIZE = Pattern.compile("(\\d{1,5})x(\\d{1,5})");

        @Override
        public ImageFormat convert(String value) {
            Matcher size = SIZE.matcher(value);
            if (!size.matches()) {
                throw new TypeConversionException(
                        "'" + value + "' is no size, expected e.g. 960x640");
            }
            try {
                return ImageFormat.of(
                        Integer.parseInt(size.group(1)), Integer.parseInt(size.group(2)));
            } catch (IllegalArgumentException tooLarge) {
                throw new TypeConversionException(tooLarge.getMessage());
            }
        }
    }
}
