// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import static org.assertj.core.api.Assertions.assertThat;

import org.eclipse.jetty.websocket.api.Callback;
import org.eclipse.jetty.websocket.api.Session;
import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;

import java.lang.reflect.Proxy;
import java.nio.ByteBuffer;
import java.nio.channels.Pipe;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.Collections;
import java.util.List;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.TimeUnit;

/** Pages that read nothing, and pages that read everything. */
class PageOutputTest {

    private static final int LIMIT_BYTES = 100;

    private final OpenPages pages = new OpenPages(LIMIT_BYTES);

    @AfterEach
    void close() {
        pages.close();
    }

    /** A WebSocket whose page reads everything or nothing. */
    private static final class Page {
        private final boolean reads;
        private final List<String> texts = Collections.synchronizedList(new ArrayList<>());
        private final List<Boolean> ends = Collections.synchronizedList(new ArrayList<>());
        private final List<Callback> unread = Collections.synchronizedList(new ArrayList<>());
        private final CompletableFuture<Boolean> asked = new CompletableFuture<>();
        private final CompletableFuture<Boolean> disconnected = new CompletableFuture<>();

        Page(boolean reads) {
            this.reads = reads;
        }

        Session session() {
            return (Session)
                    Proxy.newProxyInstance(
                            Session.class.getClassLoader(),
                            new Class<?>[] {Session.class},
                            (proxy, method, arguments) -> {
                                switch (method.getName()) {
                                    case "sendPartialText", "sendPartialBinary" ->
                                            take(
                                                    arguments[0],
                                                    (Boolean) arguments[1],
                                                    (Callback) arguments[2]);
                                    case "disconnect" -> {
                                        disconnected.complete(true);
                                        List.copyOf(unread)
                                                .forEach(
                                                        sent ->
                                                                sent.fail(
                                                                        new IllegalStateException(
                                                                                "closed")));
                                    }
                                    case "close" -> {}
                                    default -> throw new AssertionError(method);
                                }
                                return null;
                            });
        }

        private void take(Object piece, boolean last, Callback sent) {
            texts.add(piece instanceof String text ? text : "binary");
            ends.add(last);
            asked.complete(true);
            if (reads) {
                sent.succeed();
            } else {
                unread.add(sent);
            }
        }
    }

    private static void await(CompletableFuture<?> done) throws Exception {
        done.get(300, TimeUnit.SECONDS);
    }

    @Test
    void aLongLineIsSentInPiecesThatEndAtCharacters() throws Exception {
        String line = "{\"t\":\"x" + "ä€😀".repeat(9000) + "\"}";
        var page = new Page(true);
        Pipe pipe = Pipe.open();
        var output = new PageOutput(page.session(), pages);
        Thread writer =
                Thread.ofPlatform()
                        .start(
                                () -> {
                                    try (var sink = pipe.sink()) {
                                        ByteBuffer bytes =
                                                StandardCharsets.UTF_8.encode(line + "\n{}\n");
                                        while (bytes.hasRemaining()) {
                                            sink.write(bytes);
                                        }
                                    } catch (java.io.IOException e) {
                                        throw new java.io.UncheckedIOException(e);
                                    }
                                });
        PageSocket.relay(pipe.source(), output);
        writer.join();
        assertThat(String.join("", page.texts)).isEqualTo(line + "{}");
        assertThat(page.texts)
                .hasSizeGreaterThan(5)
                .allSatisfy(
                        piece ->
                                assertThat(piece.getBytes(StandardCharsets.UTF_8).length)
                                        .isLessThanOrEqualTo(PageOutput.PIECE_BYTES));
        assertThat(page.ends.stream().filter(last -> last)).hasSize(2);
        assertThat(page.ends.getLast()).isTrue();
    }

    @Test
    void aPageThatAcceptsNoPieceIsDisconnected() throws Exception {
        var page = new Page(false);
        var output = new PageOutput(page.session(), pages);
        var ended = new CompletableFuture<Throwable>();
        Thread.ofVirtual()
                .start(
                        () -> {
                            try {
                                output.line("{}", true);
                            } catch (RuntimeException e) {
                                ended.complete(e);
                            }
                        });
        await(page.asked);
        output.check(pages.nowNanos());
        assertThat(page.disconnected).isNotDone();
        output.check(pages.nowNanos() + 2 * PageOutput.PATIENCE_NANOS);
        await(page.disconnected);
        await(ended);
    }

    @Test
    void aPageThatAcceptsNoFrameIsDisconnected() throws Exception {
        var page = new Page(false);
        var output = new PageOutput(page.session(), pages);
        output.frame(List.of(), ByteBuffer.allocate(10), () -> {});
        await(page.asked);
        output.check(pages.nowNanos() + 2 * PageOutput.PATIENCE_NANOS);
        await(page.disconnected);
    }

    @Test
    void aPageIsDisconnectedSoonAfterItsSessionHasEnded() throws Exception {
        var page = new Page(true);
        var output = new PageOutput(page.session(), pages);
        output.check(pages.nowNanos() + 100 * PageOutput.PATIENCE_NANOS);
        assertThat(page.disconnected).isNotDone();
        output.endSoon();
        output.check(pages.nowNanos() + 2 * PageOutput.PATIENCE_NANOS);
        await(page.disconnected);
    }

    @Test
    void theSlowestPageLosesItsFrameWhenTooMuchWaits() throws Exception {
        var slowest = new Page(false);
        var slow = new Page(false);
        ByteBuffer shared = ByteBuffer.allocate(60);
        new PageOutput(slowest.session(), pages).frame(List.of(), shared, () -> {});
        new PageOutput(slow.session(), pages).frame(List.of(), shared, () -> {});
        assertThat(pages.bytes()).as("a shared frame counts once").isEqualTo(60);
        new PageOutput(new Page(false).session(), pages)
                .frame(List.of(), ByteBuffer.allocate(50), () -> {});
        await(slowest.disconnected);
        await(slow.disconnected);
        assertThat(pages.bytes()).isEqualTo(50);
    }
}
