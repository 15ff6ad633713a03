// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import org.jspecify.annotations.Nullable;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.concurrent.ScheduledThreadPoolExecutor;
import java.util.concurrent.ThreadPoolExecutor;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.atomic.AtomicBoolean;
import java.util.concurrent.locks.ReentrantLock;

/**
 * Renderer of scenes in a separate process. A crash in a graphics library therefore loses a picture
 * but does not end the world's process. The process starts with the first picture. The next picture
 * starts the process again if it has ended.
 *
 * <p>Any thread may call this class. Pictures are made one after the other, and callers wait for
 * their picture. {@link #close()} never waits, and aborts the picture in progress.
 */
public final class Renderer implements AutoCloseable {

    /** Default time limit for a picture. It is enough for the largest picture on a busy machine. */
    public static final Duration DEFAULT_DEADLINE = Duration.ofSeconds(60);

    private static final int ATTEMPTS = 2;

    private final Path program;
    private final Duration deadline;
    private final ReentrantLock one = new ReentrantLock(true);
    private final ScheduledThreadPoolExecutor watch;
    private volatile @Nullable RenderProcess process;
    private volatile boolean closed;

    /**
     * Creates a renderer without starting the process.
     *
     * @param nativeFolder folder of the program {@code vesper-render}
     * @param deadline time limit for one picture, including the start of the process
     */
    public Renderer(Path nativeFolder, Duration deadline) {
        this.program = nativeFolder.resolve("vesper-render");
        this.deadline = deadline;
        this.watch =
                new ScheduledThreadPoolExecutor(
                        1,
                        Thread.ofPlatform().daemon().name("vesper-render deadline").factory(),
                        new ThreadPoolExecutor.DiscardPolicy());
        watch.setRemoveOnCancelPolicy(true);
    }

    /**
     * Draws a scene.
     *
     * @return a PNG
     * @throws RenderException if the picture failed; the next picture may succeed
     * @throws IllegalStateException if a row of the scene lacks a value
     */
    public byte[] render(Scene scene) {
        return picture(scene, stream -> stream.render(scene, ""));
    }

    /**
     * Draws a scene into a file, which is replaced atomically when the picture is complete.
     *
     * @throws RenderException if the picture failed; an existing file is unchanged
     */
    public void render(Scene scene, Path file) {
        picture(scene, stream -> stream.render(scene, file.toAbsolutePath().toString()));
    }

    /**
     * Renders the requested layers of a scene.
     *
     * @param layers sum of {@link PixelLayers#COLOUR}, {@link PixelLayers#DEPTH} and {@link
     *     PixelLayers#ITEM}, at least one of them
     * @throws RenderException if rendering failed; the next attempt may succeed
     */
    public PixelLayers pixels(Scene scene, int layers) {
        byte[] bytes = picture(scene, stream -> stream.pixels(scene, layers));
        return PixelLayers.of(scene.image(), layers, bytes);
    }

    /** Ends the process. The picture in progress fails with an exception. */
    @Override
    public void close() {
        closed = true;
        watch.shutdownNow();
        killRunning();
    }

    /** Returns the process id of the running program; -1 if none runs. */
    long pid() {
        RenderProcess live = process;
        return live != null && live.isAlive() ? live.pid() : -1;
    }

    /** One exchange with the program: a request and its answer. */
    private interface Question {
        SceneStream.Answer ask(SceneStream stream) throws IOException;
    }

    private byte[] picture(Scene scene, Question question) {
        scene.requireComplete();
        one.lock();
        try {
            for (int attempt = 1; ; attempt++) {
                var expired = new AtomicBoolean();
                try {
                    return attempt(question, expired);
                } catch (IOException cut) {
                    explain(cut, expired.get(), attempt);
                }
            }
        } finally {
            one.unlock();
        }
    }

    private byte[] attempt(Question question, AtomicBoolean expired) throws IOException {
        var alarm =
                watch.schedule(
                        () -> {
                            expired.set(true);
                            killRunning();
                        },
                        deadline.toNanos(),
                        TimeUnit.NANOSECONDS);
        try {
            RenderProcess live = running();
            SceneStream.Answer answer = question.ask(live.stream());
            return switch (answer.status()) {
                case SceneStream.OK -> answer.payload();
                case SceneStream.MALFORMED -> {
                    live.kill();
                    throw new RenderException("the scene cannot be drawn: " + answer.reason());
                }
                default -> throw new RenderException(answer.reason());
            };
        } finally {
            alarm.cancel(false);
        }
    }

    private void killRunning() {
        RenderProcess live = process;
        if (live != null) {
            live.kill();
        }
    }

    /** Returns the running process. Starts a process if none runs. */
    private RenderProcess running() throws IOException {
        RenderProcess live = process;
        if (live != null && live.isAlive()) {
            return live;
        }
        if (!Files.isExecutable(program)) {
            throw new RenderException(
                    "there is no program "
                            + program
                            + "; build it, or name its folder in -Dreve.native.path");
        }
        process = null;
        RenderProcess started = new RenderProcess(program);
        process = started;
        if (closed) {
            // The method close() may have been called while the process started.
            started.kill();
        }
        SceneStream.Answer hello = started.stream().hello();
        if (hello.status() != SceneStream.OK) {
            throw new RenderException(program + " is not of this version: " + hello.reason());
        }
        return started;
    }

    /**
     * Ends the process after a failure, because the state of its stream is unknown. Returns
     * normally if another attempt may succeed. Otherwise throws an exception with the reason.
     */
    private void explain(IOException cut, boolean expired, int attempt) {
        RenderProcess broken = process;
        process = null;
        try {
            if (closed) {
                throw new RenderException(
                        "the renderer was closed before the picture was done", cut);
            }
            if (expired) {
                throw new RenderException(
                        "no picture within "
                                + deadline.toMillis()
                                + " ms, so vesper-render was ended; ask for a smaller picture,"
                                + " fewer samples, no shadows, or allow it more time",
                        cut);
            }
            if (attempt == ATTEMPTS) {
                String end = broken == null ? cut.getMessage() : broken.describeEnd();
                throw new RenderException(
                        "no picture in " + ATTEMPTS + " attempts: vesper-render " + end, cut);
            }
        } finally {
            if (broken != null) {
                broken.kill();
            }
        }
    }
}
