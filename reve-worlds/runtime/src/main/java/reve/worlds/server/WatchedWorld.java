// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.image.CorruptException;
import reve.worlds.journal.WorldHeader;

import java.io.IOException;
import java.nio.file.Path;
import java.time.Duration;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.Callable;
import java.util.function.Consumer;

/**
 * A world that another server runs and of which this server shows a {@link WorldMirror} to
 * observers. If the other server is lost or the world moves, the copy waits for the world at its
 * new place, and its observers stay connected. The copy ends when it had no clients for a time. For
 * any thread.
 */
final class WatchedWorld implements AutoCloseable {
    /** Time without clients after which the copy ends. */
    private static final Duration UNUSED = Duration.ofSeconds(10);

    /** Time without any data after which the connection to the other server counts as lost. */
    private static final Duration SILENCE = Duration.ofSeconds(5);

    /** Maximum time without a copy, after which the attempts to make one end. */
    private static final Duration PATIENCE = Duration.ofSeconds(30);

    private static final long RETRY_MILLIS = 500;

    private final String name;
    private final Callable<WorldPlan> plan;
    private final FrameSource.Connector connector;
    private final WorldHost host;
    private final ServerEvents events;
    private final Consumer<Boolean> whenClosed;
    private final Thread thread;
    private volatile boolean stopped;

    // For the thread of the copy.
    private @Nullable WorldMirror mirror;

    /** The last time at which the copy showed a frame, or the start [ns]. */
    private long shownNanos = System.nanoTime();

    /** Whether it was reported that the copy shows no frames. */
    private boolean isLost;

    /** Whether the copy has ended, because it had no clients for a time. */
    private boolean isUnused;

    /**
     * @param plan makes the plan of the world, of which the copy uses the files
     * @param host shows the copy
     * @param whenClosed is called on the thread of the copy when the copy has ended; the argument
     *     is true if it has failed
     */
    WatchedWorld(
            String name,
            Callable<WorldPlan> plan,
            FrameSource.Connector connector,
            WorldHost host,
            ServerEvents events,
            Consumer<Boolean> whenClosed) {
        this.name = name;
        this.plan = plan;
        this.connector = connector;
        this.host = host;
        this.events = events;
        this.whenClosed = whenClosed;
        this.thread = Thread.ofPlatform().name("watches world " + name).unstarted(this::live);
    }

    void start() {
        thread.start();
    }

    private void live() {
        boolean hasFailed = false;
        try {
            WorldPlan made = plan.call();
            made.pictures().close(); // this server takes none
            watch(made);
        } catch (InterruptedException closed) {
            // close() has interrupted the thread.
        } catch (Exception | Error failure) {
            hasFailed = true;
            tellProblem(String.valueOf(failure.getMessage()));
        } finally {
            whenClosed.accept(hasFailed);
        }
    }

    private void watch(WorldPlan made) throws IOException, InterruptedException {
        try {
            while (!stopped && !isUnused) {
                String problem = "";
                try (FrameSource source = connector.connect(name)) {
                    read(source, made);
                } catch (IOException | CorruptException broken) {
                    problem = String.valueOf(broken.getMessage());
                }
                long silent = System.nanoTime() - shownNanos;
                if (!isLost && silent > SILENCE.toNanos()) {
                    isLost = true;
                    tellProblem("observers see no new frames: " + problem);
                }
                if (mirror == null && silent > PATIENCE.toNanos()) {
                    throw new IOException("no copy could be made for 30 s: " + problem);
                }
                endIfUnused();
                if (!isUnused) {
                    Thread.sleep(RETRY_MILLIS);
                }
            }
        } finally {
            end(stopped ? host.hostCluster().flatMap(known -> known.refuge(name)) : here());
        }
    }

    /** Shows the frames of a feed until it ends, or the copy is not used any more. */
    private void read(FrameSource source, WorldPlan made) throws IOException, InterruptedException {
        Path folder = made.persistence().folder();
        WorldHeader header = WorldHeader.read(required(source)).in(folder);
        byte[] first = required(source);
        if (mirror != null && !mirror.continueWith(header, first)) {
            end(here());
        }
        if (mirror == null) {
            begin(
                    new WorldMirror(header, first, frame -> host.agents().rewound(name, frame)),
                    made);
        }
        if (isLost) {
            isLost = false;
            tellProblem("observers see the frames of the world again");
        }
        long checked = System.nanoTime();
        while (!stopped && !isUnused) {
            Optional<byte[]> frame = source.next(SILENCE);
            if (frame.isPresent()) {
                mirror.show(frame.get());
            }
            shownNanos = System.nanoTime();
            if (shownNanos - checked > RETRY_MILLIS * 1_000_000) {
                checked = shownNanos;
                endIfUnused();
            }
        }
    }

    private static byte[] required(FrameSource source) throws IOException, InterruptedException {
        long end = System.nanoTime() + SILENCE.toNanos();
        while (System.nanoTime() < end) {
            Optional<byte[]> data = source.next(SILENCE);
            if (data.isPresent()) {
                return data.get();
            }
        }
        throw new IOException("the node that runs the world sends no frames");
    }

    private void begin(WorldMirror begun, WorldPlan made) {
        mirror = begun;
        host.page().ifPresent(page -> page.add(begun.port(), made.description().camera()));
        host.agents().add(begun.port());
        begun.start();
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("agents", addressOf(host));
        events.happened("watching", fields);
    }

    /** Ends the copy, if there is one, and sends its observers to another address. */
    private void end(Optional<String> next) {
        WorldMirror ended = mirror;
        if (ended != null) {
            mirror = null;
            host.page().ifPresent(page -> page.remove(name));
            host.agents().remove(name, next);
            ended.close();
        }
    }

    private void endIfUnused() {
        isUnused |= mirror != null && host.agents().endIfUnused(name, UNUSED);
    }

    private Optional<String> here() {
        return Optional.of(addressOf(host));
    }

    private static String addressOf(WorldHost host) {
        return host.address().getHostString() + ":" + host.address().getPort();
    }

    private void tellProblem(String message) {
        if (!stopped) {
            events.happened("fault", WorldServer.fault("watch", message));
        }
    }

    /** Ends the copy and waits for its end. */
    @Override
    public void close() {
        stopped = true;
        thread.interrupt();
        boolean interrupted = false;
        while (thread.isAlive()) {
            try {
                thread.join();
            } catch (InterruptedException e) {
                interrupted = true; // the copy must be closed before the server of its observers
            }
        }
        if (interrupted) {
            Thread.currentThread().interrupt();
        }
    }
}
