// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.access.ActionProvider;
import reve.core.access.Effect;
import reve.core.access.ProvidedAction;
import reve.core.access.Terms;
import reve.core.agent.AgentRoom;
import reve.core.agent.TestClient;
import reve.core.agent.protocol.ServerMessage;
import reve.core.world.ActionCall;
import reve.core.world.ItemDefinition;
import reve.core.world.WorldEvent;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.io.UncheckedIOException;
import java.net.InetSocketAddress;
import java.nio.ByteBuffer;
import java.nio.channels.Pipe;
import java.nio.channels.SelectionKey;
import java.nio.charset.StandardCharsets;
import java.util.List;
import java.util.Map;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.TimeUnit;

/** The effect on agents of an error in the server, even of the virtual machine. */
class AgentErrorsTest {

    private static final long PATIENCE_SECONDS = 300;

    private AgentRoom room;

    @BeforeEach
    void open() throws IOException {
        room = new AgentRoom();
    }

    @AfterEach
    void close() {
        room.close();
    }

    @Test
    void agentsAreServedAfterAFrameThatCouldNotBeTold() throws IOException {
        try (TestClient ada = room.join("ada")) {
            room.world.raise(new WorldEvent(2, "odd", Map.of("number", new OddNumber())));
            room.step();
            ada.say("{'t':'perceive','id':1}").sync();
            room.stepUntil(
                    "a perception was handed over", () -> room.server.stats().perceptions() > 0);
            assertThat(ada.expect("perception").get("id").longValue()).isEqualTo(1);
        }
    }

    @ParameterizedTest
    @ValueSource(strings = {"fault", "law-shadow"})
    void whatAFaultWasInDetailIsForControlAlone(String type) throws IOException {
        try (TestClient ada = room.join("ada");
                TestClient boss = room.connect()) {
            boss.say("{'t':'hello','protocol':1,'name':'boss','role':'control'}");
            boss.expect("welcome");
            room.world.raise(
                    new WorldEvent(
                            room.loop.frame() + 1,
                            type,
                            Map.of(
                                    "source",
                                    "a listener",
                                    "message",
                                    "/srv/worlds/secret.log: No space left")));
            room.step();
            assertThat(boss.expect("event").toString())
                    .contains("a listener")
                    .contains("/srv/worlds");
            assertThat(ada.expect("event").toString())
                    .contains("a listener")
                    .doesNotContain("/srv/worlds");
        }
    }

    @Test
    void whatAnActionFailedOfIsForTheLogAlone() throws IOException {
        var lift =
                new ProvidedAction(
                        "lift",
                        "Breaks.",
                        Terms.NONE,
                        new ActionProvider() {
                            @Override
                            public String name() {
                                return "test.lift";
                            }

                            @Override
                            public String doc() {
                                return "Breaks.";
                            }

                            @Override
                            public List<Effect> decide(ActionCall call) {
                                throw new UncheckedIOException(
                                        new IOException("/srv/worlds/lift.dat: Permission denied"));
                            }
                        });
        room.world.add(ItemDefinition.named("lift").action(lift).build());
        try (TestClient ada = room.join("ada")) {
            ada.say("{'t':'act','id':1,'item':'lift','action':'lift'}").sync();
            room.step();
            assertThat(ada.expect("result", "action-failed").toString())
                    .doesNotContain("/srv/worlds");
        }
    }

    @Test
    void anErrorWhileReadingEndsTheConnectionWithABye() throws Exception {
        try (var wire = new OddWire(true, false)) {
            Connection connection = connect(wire);
            assertThat(wire.closed.await(PATIENCE_SECONDS, TimeUnit.SECONDS)).isTrue();
            assertThat(connection.hasEnded()).isTrue();
            assertThat(wire.written.toString(StandardCharsets.UTF_8))
                    .contains("\"code\":\"failed\"");
        }
    }

    @Test
    void anErrorWhileWritingEndsTheConnection() throws Exception {
        try (var wire = new OddWire(false, true)) {
            Connection connection = connect(wire);
            assertThat(wire.closed.await(PATIENCE_SECONDS, TimeUnit.SECONDS)).isTrue();
            assertThat(connection.hasEnded()).isTrue();
        }
    }

    /** Makes a connection with data to read and data to write. */
    private Connection connect(OddWire wire) throws Exception {
        var made = new CompletableFuture<Connection>();
        room.connections()
                .loop()
                .later(
                        () -> {
                            try {
                                var connection = new Connection(room.connections(), wire, null);
                                connection.send(new ServerMessage.Ping());
                                made.complete(connection);
                            } catch (IOException e) {
                                made.completeExceptionally(e);
                            }
                        });
        return made.get(PATIENCE_SECONDS, TimeUnit.SECONDS);
    }

    private static final class OddNumber extends Number {

        private static final long serialVersionUID = 1L;

        @Override
        public double doubleValue() {
            throw new StackOverflowError("an error of the virtual machine");
        }

        @Override
        public float floatValue() {
            return 0;
        }

        @Override
        public long longValue() {
            return 0;
        }

        @Override
        public int intValue() {
            return 0;
        }
    }

    /** A client that sends data and closes; reading from or writing to it then fails. */
    private static final class OddWire implements Wire {

        private final Pipe pipe = Pipe.open();
        private final ByteArrayOutputStream written = new ByteArrayOutputStream();
        private final CountDownLatch closed = new CountDownLatch(1);
        private final boolean failsToRead;
        private final boolean failsToWrite;

        OddWire(boolean failsToRead, boolean failsToWrite) throws IOException {
            this.failsToRead = failsToRead;
            this.failsToWrite = failsToWrite;
            pipe.sink().close();
        }

        @Override
        public InetSocketAddress peer() {
            return new InetSocketAddress(0);
        }

        @Override
        public SelectionKey register(EventLoop loop, EventLoop.Handler handler, Runnable readable)
                throws IOException {
            return loop.register(pipe.source(), SelectionKey.OP_READ, handler);
        }

        @Override
        public int read(ByteBuffer bytes) {
            if (failsToRead) {
                throw new OutOfMemoryError("an error of the virtual machine");
            }
            return -1;
        }

        @Override
        public int write(ByteBuffer bytes) {
            if (failsToWrite) {
                throw new OutOfMemoryError("an error of the virtual machine");
            }
            int count = bytes.remaining();
            while (bytes.hasRemaining()) {
                written.write(bytes.get());
            }
            return count;
        }

        @Override
        public void shutdownOutput() {
            // No thread waits for it.
        }

        @Override
        public boolean isOpen() {
            return pipe.source().isOpen();
        }

        @Override
        public void close() throws IOException {
            pipe.source().close();
            closed.countDown();
        }
    }
}
