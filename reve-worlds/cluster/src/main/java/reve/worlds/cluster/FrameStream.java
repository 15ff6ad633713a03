// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import org.apache.pekko.actor.typed.ActorSystem;
import org.apache.pekko.stream.Attributes;
import org.apache.pekko.stream.SourceRef;
import org.apache.pekko.stream.StreamRefAttributes;
import org.apache.pekko.stream.StreamRefResolver;
import org.apache.pekko.stream.javadsl.Sink;
import org.apache.pekko.stream.javadsl.SinkQueueWithCancel;
import org.apache.pekko.stream.javadsl.Source;
import org.apache.pekko.stream.javadsl.StreamRefs;

import reve.worlds.server.FrameFeed;
import reve.worlds.server.FrameSource;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.time.Duration;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Optional;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.ExecutionException;
import java.util.concurrent.Executor;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.TimeoutException;

/**
 * The frames of a world as a stream of Pekko between two nodes. The reading node requests the
 * parts, so that a slow node gets fewer frames, and no frame is lost on the way. Each element of
 * the stream is a part of a frame, with one byte in front that says whether it is the last part.
 */
final class FrameStream implements FrameSource {
    /** Maximum size of an element [bytes]. Pekko's messages have at most 256 KiB. */
    private static final int PART_BYTES = 64 * 1024;

    private static final byte MORE = 0;
    private static final byte LAST = 1;

    /** An element without a frame, which shows that the other node is alive. */
    private static final byte ALIVE = 2;

    /** Interval between two signs of life of a world that makes no frames. */
    private static final Duration BEAT = Duration.ofSeconds(1);

    /** Number of elements that may be on their way to the reading node. */
    private static final int ON_THEIR_WAY = 8;

    private static final Executor THREADS = task -> Thread.ofVirtual().name("feed").start(task);

    private final SinkQueueWithCancel<byte[]> queue;

    /** The parts of a frame that is not complete yet. */
    private final ByteArrayOutputStream parts = new ByteArrayOutputStream();

    private FrameStream(SinkQueueWithCancel<byte[]> queue) {
        this.queue = queue;
    }

    /**
     * Offers a feed to another node, and closes it when that node reads no more.
     *
     * @return text with which the other node calls {@link #open}
     */
    static String offer(FrameFeed feed, ActorSystem<?> system) {
        SourceRef<byte[]> ref =
                Source.unfoldResourceAsync(
                                () -> CompletableFuture.completedFuture(feed),
                                FrameStream::read,
                                open -> {
                                    open.close();
                                    return CompletableFuture.completedFuture(null);
                                })
                        .mapConcat(parts -> parts)
                        .runWith(StreamRefs.<byte[]>sourceRef(), system);
        return StreamRefResolver.get(system).toSerializationFormat(ref);
    }

    private static CompletableFuture<Optional<List<byte[]>>> read(FrameFeed feed) {
        return CompletableFuture.supplyAsync(
                () -> {
                    try {
                        Optional<byte[]> frame = feed.next(BEAT);
                        if (frame.isPresent()) {
                            return Optional.of(parts(frame.get()));
                        }
                        return feed.isClosed()
                                ? Optional.empty()
                                : Optional.of(List.of(new byte[] {ALIVE}));
                    } catch (InterruptedException ended) {
                        return Optional.empty();
                    }
                },
                THREADS);
    }

    private static List<byte[]> parts(byte[] frame) {
        List<byte[]> parts = new ArrayList<>();
        int begin = 0;
        do {
            int end = Math.min(frame.length, begin + PART_BYTES);
            byte[] part = new byte[1 + end - begin];
            part[0] = end == frame.length ? LAST : MORE;
            System.arraycopy(frame, begin, part, 1, end - begin);
            parts.add(part);
            begin = end;
        } while (begin < frame.length);
        return parts;
    }

    /** Opens the stream that another node has offered. */
    static FrameStream open(String offered, ActorSystem<?> system) {
        SourceRef<byte[]> ref = StreamRefResolver.get(system).resolveSourceRef(offered);
        return new FrameStream(
                ref.getSource()
                        .withAttributes(StreamRefAttributes.bufferCapacity(ON_THEIR_WAY))
                        .runWith(
                                Sink.<byte[]>queue().withAttributes(Attributes.inputBuffer(1, 1)),
                                system));
    }

    @Override
    public Optional<byte[]> next(Duration timeout) throws IOException, InterruptedException {
        while (true) {
            byte[] part = part(timeout);
            if (part[0] == ALIVE) {
                return Optional.empty();
            }
            if (part[0] == LAST && parts.size() == 0) {
                return Optional.of(Arrays.copyOfRange(part, 1, part.length));
            }
            parts.write(part, 1, part.length - 1);
            if (part[0] == LAST) {
                byte[] frame = parts.toByteArray();
                parts.reset();
                return Optional.of(frame);
            }
        }
    }

    private byte[] part(Duration timeout) throws IOException, InterruptedException {
        try {
            return queue.pull()
                    .toCompletableFuture()
                    .get(timeout.toMillis(), TimeUnit.MILLISECONDS)
                    .orElseThrow(() -> new IOException("the world has ended on its node"));
        } catch (TimeoutException silent) {
            throw new IOException(
                    "the node that runs the world has sent nothing for "
                            + timeout.toSeconds()
                            + " s",
                    silent);
        } catch (ExecutionException broken) {
            throw new IOException(
                    "the connection to the node that runs the world is lost: "
                            + broken.getCause().getMessage(),
                    broken);
        }
    }

    @Override
    public void close() {
        queue.cancel();
    }
}
