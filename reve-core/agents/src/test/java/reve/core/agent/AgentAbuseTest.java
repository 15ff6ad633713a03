// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import com.sun.management.UnixOperatingSystemMXBean;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.agent.protocol.AgentLimits;
import reve.core.world.ItemDefinition;

import tools.jackson.databind.JsonNode;

import java.io.BufferedReader;
import java.io.IOException;
import java.io.InputStreamReader;
import java.io.OutputStream;
import java.lang.management.ManagementFactory;
import java.net.InetSocketAddress;
import java.net.Socket;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.time.Duration;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.Set;
import java.util.TreeMap;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.ExecutorService;
import java.util.concurrent.Executors;
import java.util.concurrent.Future;
import java.util.concurrent.FutureTask;
import java.util.concurrent.Semaphore;
import java.util.concurrent.locks.LockSupport;
import java.util.stream.Collectors;

/**
 * Many faulty clients of every kind at once: the server disconnects each with a reason, and correct
 * agents complete their work.
 */
@Tag("slow")
class AgentAbuseTest {

    /** Number of clients of each kind. A long run uses a thousand. */
    private static final int CLIENTS = Integer.getInteger("reve.abuse.clients", 40);

    /** Number of faulty clients at the same time, so that places remain for correct ones. */
    private static final int AT_ONCE = 400;

    private static final Duration PATIENCE = Duration.ofMinutes(10);
    private static final int ROUND_TRIPS = 200;
    private static final int GOOD = 4;
    private static final int STONES = 200;

    private static final Duration HELLO = Duration.ofSeconds(6); // also on a busy machine
    private static final Duration SOON = Duration.ofMillis(500);
    private static final Duration IDLE = Duration.ofSeconds(2);
    private static final long MAX_HEAP_GROWTH = 64L * 1024 * 1024;
    private static final long FRAME_NANOS = 1_000_000;
    private static final int MAX_MORE_FILES = 8; // an error of the virtual machine itself

    /** Number of last characters of a stream in which the test searches for a `bye`. */
    private static final int LAST = 300;

    private static final String PINGS = "{\"t\":\"ping\"}\n".repeat(500);

    /** The behaviour of a faulty client, and the codes with which the server may disconnect it. */
    private enum Kind {
        SAYS_NOTHING("hello-late") {
            @Override
            void behave(Attacker attacker) {
                // It sends nothing.
            }
        },
        TALKS_BEFORE_IT_GREETS("line-too-long", "hello-too-long") {
            @Override
            void behave(Attacker attacker) throws IOException {
                attacker.say("x".repeat(attacker.random.nextInt(9000, 100_000)));
            }
        },
        DRIPS_ITS_HELLO("hello-late") {
            @Override
            void behave(Attacker attacker) throws IOException {
                String hello = attacker.hello("");
                for (int i = 0; i < hello.length() / 2; i++) {
                    attacker.say(hello.substring(i, i + 1));
                }
            }
        },
        SENDS_NOISE(
                "too-many-errors",
                "line-too-long",
                "hello-too-long",
                "hello-late",
                "lost",
                "tls-unsupported") {
            @Override
            void behave(Attacker attacker) throws IOException {
                byte[] noise = new byte[attacker.random.nextInt(1, 20_000)];
                attacker.random.nextBytes(noise);
                attacker.send(noise);
                attacker.socket.shutdownOutput();
            }
        },
        BEGINS_WELL("line-late") {
            @Override
            void behave(Attacker attacker) throws IOException {
                String act = "{\"t\":\"act\",\"id\":1,\"item\":\"duck\",\"action\":\"wind-up\"}";
                attacker.say(
                        attacker.hello("")
                                + act.substring(0, attacker.random.nextInt(1, act.length())));
            }
        },
        SAYS_ALL_THAT_IT_MAY_NOT("too-many-errors") {
            @Override
            void behave(Attacker attacker) throws IOException {
                attacker.say(attacker.hello(""));
                for (String type :
                        List.of(
                                "pause",
                                "run",
                                "step",
                                "shut-down",
                                "picture",
                                "load-law",
                                "hello",
                                "welcome",
                                "act")) {
                    attacker.say(
                            "{\"t\":\""
                                    + type
                                    + "\",\"id\":"
                                    + -attacker.random.nextInt(5)
                                    + "}\n");
                }
            }
        },
        ANNOUNCES_TOO_MUCH("line-too-long") {
            @Override
            void behave(Attacker attacker) throws IOException {
                attacker.say(attacker.hello(",\"encoding\":\"msgpack\""));
                attacker.send(ByteBuffer.allocate(4).putInt(Integer.MAX_VALUE).array());
            }
        },
        ANNOUNCES_AND_WAITS("line-late") {
            @Override
            void behave(Attacker attacker) throws IOException {
                attacker.say(attacker.hello(",\"encoding\":\"msgpack\""));
                attacker.send(ByteBuffer.allocate(4).putInt(4000).array());
            }
        },
        PACKS_RUBBISH("too-many-errors") {
            @Override
            void behave(Attacker attacker) throws IOException {
                attacker.say(attacker.hello(",\"encoding\":\"msgpack\""));
                for (int i = 0; i < 8; i++) {
                    byte[] rubbish = new byte[attacker.random.nextInt(1, 100)];
                    attacker.random.nextBytes(rubbish);
                    rubbish[0] = (byte) 0xc1; // the only byte that MessagePack never uses
                    attacker.send(
                            ByteBuffer.allocate(4 + rubbish.length)
                                    .putInt(rubbish.length)
                                    .put(rubbish)
                                    .array());
                }
            }
        },
        NEVER_READS("too-slow") {
            @Override
            void behave(Attacker attacker) throws IOException {
                attacker.say(attacker.hello("") + "{\"t\":\"perceive\",\"every\":1,\"id\":1}\n");
                while (true) {
                    attacker.say(PINGS); // until the server closes the connection
                }
            }
        },
        READS_A_BYTE_AT_A_TIME("too-slow") {
            @Override
            void behave(Attacker attacker) throws IOException {
                attacker.say(attacker.hello("") + "{\"t\":\"perceive\",\"every\":1,\"id\":1}\n");
                while (attacker.socket.getInputStream().read() >= 0) {
                    attacker.say(PINGS);
                }
            }
        },
        VANISHES("idle") {
            @Override
            void behave(Attacker attacker) throws IOException {
                // It answers nothing, like a machine after a power failure.
                attacker.say(attacker.hello(""));
            }
        },
        KNOCKS_A_HUNDRED_TIMES("lost") {
            @Override
            void behave(Attacker attacker) throws IOException {
                for (int i = 0; i < 100; i++) {
                    try (var knock = new Socket()) {
                        knock.connect(attacker.socket.getRemoteSocketAddress());
                    }
                }
                attacker.socket.close();
            }
        },
        COMES_AND_GOES("lost") {
            @Override
            void behave(Attacker attacker) throws IOException {
                attacker.say(attacker.hello(",\"graceSeconds\":0.001"));
                attacker.socket.close();
            }
        };

        private final Set<String> codes;

        Kind(String... codes) {
            this.codes = Set.of(codes);
        }

        abstract void behave(Attacker attacker) throws IOException;
    }

    /** A faulty client, which runs in a thread of its own. */
    private static final class Attacker {
        private final Kind kind;
        private final String name;
        private final Random random;
        private final Socket socket = new Socket();
        private final OutputStream out;

        Attacker(InetSocketAddress address, Kind kind, int number, long seed) throws IOException {
            this.kind = kind;
            this.name = kind.name() + number;
            this.random = new Random(seed + 31L * number + kind.ordinal());
            socket.connect(address);
            socket.setSoTimeout(300_000);
            out = socket.getOutputStream();
        }

        String hello(String more) {
            return "{\"t\":\"hello\",\"protocol\":1,\"name\":\"" + name + "\"" + more + "}\n";
        }

        void say(String text) throws IOException {
            send(text.getBytes(StandardCharsets.UTF_8));
        }

        void send(byte[] bytes) throws IOException {
            out.write(bytes);
        }

        /**
         * @return the code with which the server disconnected it; empty if the connection was reset
         *     first
         */
        String attack() {
            try (socket) {
                kind.behave(this);
                return socket.isClosed() ? "" : end();
            } catch (IOException e) {
                return "";
            }
        }

        private String end() throws IOException {
            byte[] heard = socket.getInputStream().readAllBytes();
            String text = new String(heard, StandardCharsets.ISO_8859_1);
            String last = text.substring(Math.max(0, text.length() - LAST));
            return kind.codes.stream()
                    .filter(last::contains)
                    .findFirst()
                    .orElse("no bye: …" + last);
        }
    }

    @Test
    void badClientsOfEveryKindGetAReasonAndGoodAgentsNoticeNothing() throws Exception {
        long seed = Seed.of("the abuse");
        try (AgentRoom room = new AgentRoom(config());
                ExecutorService threads = Executors.newVirtualThreadPerTaskExecutor()) {
            for (int i = 0; i < STONES; i++) {
                room.world.add(
                        ItemDefinition.named("stone " + i).symbol("note", "x".repeat(200)).build());
            }
            goodAgents(room, "warm");
            long heap = usedHeap();
            long files = openFiles();
            double alone = goodAgents(room, "alone");

            var endings = new ConcurrentLinkedQueue<String>();
            var places = new Semaphore(AT_ONCE);
            List<Future<?>> attackers = new ArrayList<>();
            for (int i = 0; i < CLIENTS; i++) {
                for (Kind kind : Kind.values()) {
                    int number = i;
                    attackers.add(
                            threads.submit(
                                    () -> {
                                        places.acquire();
                                        try {
                                            String code =
                                                    new Attacker(
                                                                    room.server.address(),
                                                                    kind,
                                                                    number,
                                                                    seed)
                                                            .attack();
                                            endings.add(kind + " " + code);
                                        } finally {
                                            places.release();
                                        }
                                        return null;
                                    }));
                }
            }
            double attacked = goodAgents(room, "good");
            room.stepUntil("all bad clients have ended", PATIENCE, () -> areDone(attackers));
            for (Future<?> attacker : attackers) {
                attacker.get();
            }
            double after = goodAgents(room, "after");
            room.stepUntil(
                    "all are gone",
                    () -> room.server.stats().open() == 0 && room.server.stats().agents() == 0);
            room.step();

            System.out.printf(
                    "median round trip of a good agent [us]: "
                            + "alone %.0f, attacked %.0f, afterwards %.0f%n",
                    alone, attacked, after);
            Map<String, Long> counts =
                    endings.stream()
                            .collect(
                                    Collectors.groupingBy(
                                            ending -> ending, TreeMap::new, Collectors.counting()));
            System.out.println(counts);
            assertThat(endings).hasSize(CLIENTS * Kind.values().length);
            assertThat(counts.keySet()).noneMatch(ending -> ending.contains("no bye"));
            long cut =
                    endings.stream()
                            .filter(ending -> ending.matches(".* (idle|(hello|line|too)-.*)"))
                            .count();
            assertThat(room.server.stats().cut())
                    .as("with those that never read")
                    .isGreaterThanOrEqualTo(cut + CLIENTS);
            assertThat(room.world.table("body").rowCount())
                    .as("bodies that are left")
                    .isEqualTo(STONES + 1);
            assertThat(openFiles() - files)
                    .as("more open files")
                    .isLessThanOrEqualTo(MAX_MORE_FILES);
            assertThat(usedHeap() - heap).as("more memory").isLessThan(MAX_HEAP_GROWTH);
        }
    }

    /** The protocol's limits, except the time that a faulty client may take. */
    private static AgentServerConfig config() {
        AgentServerConfig c = AgentRoom.config(HELLO, SOON, IDLE, SOON);
        AgentLimits l = c.limits();
        AgentLimits all = AgentLimits.PROTOCOL;
        var limits =
                new AgentLimits(
                        l.maxConnections(),
                        l.helloBytes(),
                        l.lineBytes(),
                        l.messagesPerSecond(),
                        l.actsInFlight(),
                        all.outboxMessages(),
                        all.outboxBytes(),
                        l.maxErrors(),
                        l.kept(),
                        l.resumes(),
                        l.hellos());
        return new AgentServerConfig(c.address(), limits, c.timeouts(), c.audit(), c.security());
    }

    /**
     * Agents that act and perceive in turn.
     *
     * @return the median time of both [us]
     */
    private static double goodAgents(AgentRoom room, String name) throws Exception {
        List<Future<long[]>> agents = new ArrayList<>();
        for (int i = 0; i < GOOD; i++) {
            String client = name + i;
            var agent = new FutureTask<long[]>(() -> roundTrips(room.server.address(), client));
            agents.add(agent);
            Thread.ofPlatform().name(client).start(agent);
        }
        room.stepUntil("good agents are done", PATIENCE, () -> areDone(agents));
        long[] all = new long[0];
        for (Future<long[]> agent : agents) {
            long[] times = agent.get();
            all = Arrays.copyOf(all, all.length + times.length);
            System.arraycopy(times, 0, all, all.length - times.length, times.length);
        }
        Arrays.sort(all);
        return all[all.length / 2] / 1e3;
    }

    /**
     * Waits for the time of a frame, which is at least a millisecond, and returns whether all
     * clients are done.
     */
    private static boolean areDone(List<? extends Future<?>> clients) {
        LockSupport.parkNanos(FRAME_NANOS);
        return clients.stream().allMatch(Future::isDone);
    }

    private static long[] roundTrips(InetSocketAddress address, String name) throws IOException {
        long[] times = new long[ROUND_TRIPS];
        try (Socket socket = connected(address)) {
            var in =
                    new BufferedReader(
                            new InputStreamReader(socket.getInputStream(), StandardCharsets.UTF_8));
            say(socket, "{'t':'hello','protocol':1,'name':'" + name + "'}");
            assertThat(next(socket, in, "welcome").get("agent").stringValue()).isEqualTo(name);
            for (int i = 0; i < ROUND_TRIPS; i++) {
                long began = System.nanoTime();
                say(socket, "{'t':'act','id':" + 2 * i + ",'item':'duck','action':'wind-up'}");
                JsonNode result = next(socket, in, "result");
                assertThat(result.get("accepted").booleanValue()).as("%s", result).isTrue();
                say(socket, "{'t':'perceive','id':" + (2 * i + 1) + "}");
                assertThat(next(socket, in, "perception").get("frame").longValue())
                        .isGreaterThanOrEqualTo(result.get("frame").longValue());
                times[i] = System.nanoTime() - began;
            }
            say(socket, "{'t':'bye'}");
            assertThat(next(socket, in, "bye").get("code").stringValue()).isEqualTo("goodbye");
        }
        return times;
    }

    private static Socket connected(InetSocketAddress address) throws IOException {
        var socket = new Socket(address.getAddress(), address.getPort());
        socket.setTcpNoDelay(true);
        socket.setSoTimeout(300_000);
        return socket;
    }

    private static void say(Socket socket, String line) throws IOException {
        socket.getOutputStream()
                .write((line.replace('\'', '"') + "\n").getBytes(StandardCharsets.UTF_8));
    }

    private static JsonNode next(Socket socket, BufferedReader in, String type) throws IOException {
        while (true) {
            JsonNode message = TestClient.json(in.readLine());
            String found = message.get("t").stringValue();
            if (found.equals(type)) {
                return message;
            }
            if (found.equals("ping")) {
                say(socket, "{'t':'pong'}");
            } else {
                assertThat(found).as("%s", message).isEqualTo("event");
            }
        }
    }

    private static long usedHeap() {
        System.gc();
        return ManagementFactory.getMemoryMXBean().getHeapMemoryUsage().getUsed();
    }

    private static long openFiles() {
        return ((UnixOperatingSystemMXBean) ManagementFactory.getOperatingSystemMXBean())
                .getOpenFileDescriptorCount();
    }
}
