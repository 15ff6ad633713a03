package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.io.InputStream;
import java.io.OutputStream;
import java.net.Socket;
import java.nio.charset.StandardCharsets;
import java.time.Duration;
import java.util.Map;
import java.util.concurrent.CountDownLatch;
import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import reve.core.world.WorldEvent;

/** What an error in the server itself, even of the virtual machine, costs agents. */
class AgentErrorsTest {

    private static final Duration PATIENCE = Duration.ofSeconds(20);

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
            room.stepUntil("a perception was handed over",
                    () -> room.server.stats().perceptions() > 0);
            assertThat(ada.expect("perception").get("id").longValue()).isEqualTo(1);
        }
    }

    @Test
    void anErrorWhileReadingEndsTheConnectionWithABye() throws Exception {
        var written = new ByteArrayOutputStream();
        var session = new Connection(room.server, new OddSocket(written, true, false));
        session.start();
        assertThat(session.join(PATIENCE)).isTrue();
        assertThat(written.toString(StandardCharsets.UTF_8)).contains("\"code\":\"failed\"");
    }

    @Test
    void anErrorWhileWritingEndsTheConnection() throws Exception {
        var session = new Connection(room.server,
                new OddSocket(new ByteArrayOutputStream(), false, true));
        session.start();
        assertThat(session.join(PATIENCE)).isTrue();
        assertThat(session.hasEnded()).isTrue();
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

    /** A connection whose client says nothing; one of its ends fails. */
    private static final class OddSocket extends Socket {

        private final CountDownLatch closed = new CountDownLatch(1);
        private final OutputStream written;
        private final boolean failsToRead;
        private final boolean failsToWrite;

        OddSocket(OutputStream written, boolean failsToRead, boolean failsToWrite) {
            this.written = written;
            this.failsToRead = failsToRead;
            this.failsToWrite = failsToWrite;
        }

        @Override
        public void setTcpNoDelay(boolean on) {
            if (failsToRead) {
                throw new OutOfMemoryError("an error of the virtual machine");
            }
        }

        @Override
        public OutputStream getOutputStream() {
            if (failsToWrite) {
                throw new OutOfMemoryError("an error of the virtual machine");
            }
            return written;
        }

        @Override
        public InputStream getInputStream() {
            return new InputStream() {
                @Override
                public int read() throws IOException {
                    try {
                        closed.await();
                        return -1;
                    } catch (InterruptedException e) {
                        throw new IOException(e);
                    }
                }
            };
        }

        @Override
        public void setSoTimeout(int millis) {
            // waits until it is closed
        }

        @Override
        public void close() throws IOException {
            closed.countDown();
            super.close();
        }
    }
}
