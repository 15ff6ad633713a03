// SPDX-License-Identifier: Apache-2.0
package reve.worlds.picture;

import org.jspecify.annotations.Nullable;

import reve.core.disk.PartFile;

import java.awt.image.BufferedImage;
import java.io.BufferedOutputStream;
import java.io.File;
import java.io.IOException;
import java.io.InputStream;
import java.io.OutputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;

/** A video that the program ffmpeg encodes in a separate process. */
public final class Ffmpeg implements FrameSink {
    private static final String PROGRAM = "ffmpeg";
    private static final int MESSAGE_CHARACTERS = 2000;
    private static final Duration PATIENCE = Duration.ofSeconds(5);

    /** The options for the encoder and the format, by the ending of the file name. */
    private static final Map<String, String> FORMATS =
            Map.of(
                    ".mp4",
                    "-c:v libx264 -preset medium -crf 18 -pix_fmt yuv420p"
                            + " -vf pad=ceil(iw/2)*2:ceil(ih/2)*2 -movflags +faststart -f mp4",
                    ".webm",
                    "-c:v libvpx-vp9 -crf 24 -b:v 0 -f webm",
                    ".webp",
                    "-c:v libwebp_anim -q:v 80 -loop 0 -f webp");

    /** Text that each file contains near its beginning, by the ending of the file name. */
    private static final Map<String, String> MARKS =
            Map.of(".mp4", "ftyp", ".webm", "webm", ".webp", "WEBP");

    private final Path place;
    private final Path part;
    private final Process process;
    private final Thread reader;
    private final StringBuffer errors = new StringBuffer();
    private final OutputStream out;
    private byte[] bytes = new byte[0];
    private boolean finished;

    /**
     * Starts the program.
     *
     * @param program the path of the program that {@link #find()} returns
     * @param fps pictures per second
     * @throws IOException if the program cannot be started
     */
    public Ffmpeg(Path program, Path place, int width, int height, int fps) throws IOException {
        this.place = place;
        part = PartFile.create(place);
        List<String> command = new ArrayList<>(List.of(program.toString()));
        command.addAll(List.of("-hide_banner", "-loglevel", "error", "-y"));
        command.addAll(List.of("-f", "rawvideo", "-pix_fmt", "rgb24"));
        command.addAll(List.of("-s", width + "x" + height, "-r", Integer.toString(fps)));
        command.addAll(List.of("-i", "-", "-map_metadata", "-1"));
        command.addAll(List.of("-fflags", "+bitexact", "-flags:v", "+bitexact"));
        command.addAll(List.of(FORMATS.get(ending(place)).split(" ")));
        command.add(part.toAbsolutePath().toString());
        process =
                new ProcessBuilder(command).redirectOutput(ProcessBuilder.Redirect.DISCARD).start();
        reader = Thread.ofPlatform().daemon().name("ffmpeg errors").start(this::readErrors);
        out = new BufferedOutputStream(process.getOutputStream(), 1 << 16);
    }

    /** Returns whether ffmpeg encodes files with this ending. */
    public static boolean isFor(Path file) {
        return FORMATS.containsKey(ending(file));
    }

    /** Returns a text that each file with this ending contains near its beginning. */
    public static String mark(Path file) {
        return MARKS.get(ending(file));
    }

    private static String ending(Path file) {
        String name = file.getFileName().toString().toLowerCase(Locale.ROOT);
        return name.substring(Math.max(0, name.lastIndexOf('.')));
    }

    /** Returns the program; empty if the search path of the process has none. */
    public static Optional<Path> find() {
        String path = System.getenv("PATH");
        return path == null ? Optional.empty() : find(path);
    }

    static Optional<Path> find(String path) {
        for (String folder : path.split(File.pathSeparator)) {
            // An entry that is empty or relative is skipped. It means the current folder, which may
            // belong to another user.
            Path program = Path.of(folder).resolve(PROGRAM);
            if (program.isAbsolute() && Files.isExecutable(program)) {
                return Optional.of(program);
            }
        }
        return Optional.empty();
    }

    @Override
    public void add(BufferedImage picture) throws IOException {
        int width = picture.getWidth();
        int[] rgb = picture.getRGB(0, 0, width, picture.getHeight(), null, 0, width);
        if (bytes.length != 3 * rgb.length) {
            bytes = new byte[3 * rgb.length];
        }
        for (int i = 0; i < rgb.length; i++) {
            bytes[3 * i] = (byte) (rgb[i] >> 16);
            bytes[3 * i + 1] = (byte) (rgb[i] >> 8);
            bytes[3 * i + 2] = (byte) rgb[i];
        }
        try {
            out.write(bytes);
        } catch (IOException e) {
            throw failed(e);
        }
    }

    private void readErrors() {
        try (InputStream in = process.getErrorStream()) {
            byte[] piece = new byte[1024];
            for (int count = in.read(piece); count >= 0; count = in.read(piece)) {
                errors.append(new String(piece, 0, count, StandardCharsets.UTF_8));
                errors.delete(0, Math.max(0, errors.length() - MESSAGE_CHARACTERS));
            }
        } catch (IOException closed) {
            errors.append(closed.getMessage());
        }
    }

    private IOException failed(@Nullable IOException cause) {
        try {
            reader.join(PATIENCE); // waits before the end of the process closes the stream
        } catch (InterruptedException e) {
            Thread.currentThread().interrupt();
        }
        String reason = errors.toString().strip();
        return new IOException(
                place + ": ffmpeg failed: " + (reason.isEmpty() ? "it gave no reason" : reason),
                cause);
    }

    @Override
    public void finish() throws IOException {
        try {
            out.close();
        } catch (IOException e) {
            throw failed(e);
        }
        try {
            if (process.waitFor() != 0) {
                throw failed(null);
            }
        } catch (InterruptedException e) {
            Thread.currentThread().interrupt();
            throw new IOException(place + ": interrupted while ffmpeg encoded", e);
        }
        PartFile.move(part, place, StandardCopyOption.REPLACE_EXISTING);
        finished = true;
    }

    @Override
    public void close() throws IOException {
        process.destroyForcibly().onExit().join();
        if (!finished) {
            PartFile.remove(part);
        }
    }
}
