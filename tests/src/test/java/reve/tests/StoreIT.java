package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import java.io.IOException;
import java.nio.file.Path;
import java.util.List;
import java.util.Map;
import java.util.Random;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.AgentException;
import reve.agent.DisconnectedException;
import reve.tests.Reve.Outcome;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

/** Real servers with real agents: killed and resumed, recorded and replayed. */
class StoreIT {
    private static final String WORLD = Project.WORLDS.resolve("spring-orbit").toString();
    private static final long SEED = 20261121;
    /** 200 in a long run. */
    private static final int KILLS = Integer.getInteger("reve.test.kills", 6);

    @TempDir
    private Path folder;

    /** Every resumed state is the one that the recording of the killed run has for that frame. */
    @Test
    void aWorldThatIsKilledWhileItIsSavedGoesOnAsItWas() throws Exception {
        Random random = new Random(SEED);
        Path store = folder.resolve("my.db");
        Path log = folder.resolve("none");
        long lastAct = 0;
        int compared = 0;
        long mostLost = 0;
        for (int kill = 0; kill <= KILLS; kill++) {
            Path nextLog = folder.resolve("run" + kill + ".log");
            try (Server server = Server.start(folder, "serve", WORLD, "--port", "0", "--json",
                    "--store", store.toString(), "--store-every", "0.3", "--record",
                    nextLog.toString())) {
                JsonNode ready = server.events().await("ready", event -> true);
                long frame = ready.path("frame").asLong();
                if (kill > 0) {
                    mostLost = Math.max(mostLost, lastAct - frame);
                    JsonNode replayed = replay(log, frame);
                    assertThat(replayed.path("identical").asBoolean()).as(replayed.toString())
                            .isTrue();
                    if (replayed.path("frame").asLong() == frame) {
                        compared++;
                        assertThat(ready.path("stateHash").asString())
                                .as("kill %d, frame %d, seed %d", kill, frame, SEED)
                                .isEqualTo(replayed.path("stateHash").asString());
                    }
                }
                lastAct = Math.max(frame, actUntilKilled(server, ready, random));
            }
            log = nextLog;
        }
        System.out.printf("%d kills, %d states compared, %d frames lost at most%n", KILLS, compared,
                mostLost);
        assertThat(compared).isPositive();
    }

    @Test
    void whatAgentsDoIsReplayedToTheBit() throws Exception {
        Path log = folder.resolve("run.log");
        String hash;
        try (Server server = Server.start(folder, "serve", WORLD, "--port", "0", "--json",
                "--seconds", "4", "--record", log.toString())) {
            JsonNode ready = server.events().await("ready", event -> true);
            String port = ready.path("agentPort").asString();
            Process python = curious(port);
            try (AgentClient agent =
                    AgentClient.connect("127.0.0.1", Integer.parseInt(port), "ada")) {
                Random random = new Random(SEED);
                for (int i = 0; i < 100; i++) {
                    act(agent, random);
                }
            }
            JsonNode end = server.events().await("end", event -> true);
            assertThat(end.at("/agents/joined").asLong()).isEqualTo(2);
            assertThat(end.at("/agents/actsAccepted").asLong()).isGreaterThanOrEqualTo(100);
            hash = end.path("stateHash").asString();
            python.waitFor();
            assertThat(server.exitCode()).isZero();
        }
        Outcome replay = Reve.run("replay", log.toString());
        assertThat(replay.code()).as(replay.out() + replay.err()).isZero();
        assertThat(replay.out()).contains("identical: 240 frames", "state hash: " + hash);
    }

    @Test
    void aStoreOfAnotherWorldIsRefused() throws Exception {
        Path store = folder.resolve("my.db");
        Outcome first = Reve.run("serve", WORLD, "--port", "0", "--store", store.toString(),
                "--seconds", "0.1", "--fast");
        assertThat(first.code()).as(first.err()).isZero();
        Outcome other = Reve.run("serve", Project.WORLDS.resolve("icosahedron").toString(),
                "--port", "0", "--store", store.toString(), "--seconds", "0.1", "--fast");
        assertThat(other.code()).isEqualTo(1);
        assertThat(other.err()).contains("my.db", "is called spring-orbit",
                "the world file's icosahedron");
    }

    private Process curious(String port) throws IOException {
        Path agents = Project.ROOT.resolve("agents/python");
        ProcessBuilder python = new ProcessBuilder("python3",
                agents.resolve("examples/curious.py").toString(), "--port", port, "--seconds", "2")
                .redirectErrorStream(true).redirectOutput(folder.resolve("python.out").toFile());
        python.environment().put("PYTHONPATH", agents.toString());
        return python.start();
    }

    /** Pushes and paints until the server is killed at a random moment; the last act's frame. */
    private static long actUntilKilled(Server server, JsonNode ready, Random random)
            throws IOException {
        long moment = System.nanoTime() + 200_000_000L + random.nextInt(1_200) * 1_000_000L;
        long last = 0;
        try (AgentClient agent = AgentClient.connect("127.0.0.1",
                ready.path("agentPort").asInt(), "ada")) {
            while (System.nanoTime() < moment) {
                last = act(agent, random).frame().orElse(last);
            }
            server.process().destroyForcibly();
            server.process().onExit().join();
        } catch (AgentException gone) {
            assertThat(gone).isInstanceOf(DisconnectedException.class);
        }
        return last;
    }

    private static ActResult act(AgentClient agent, Random random) {
        return random.nextInt(4) == 0
                ? agent.act("red", "paint", Map.of("colour",
                        String.format("#%06x", random.nextInt(1 << 24))))
                : agent.act("blue", "push", Map.of("impulse", List.of(random.nextGaussian(),
                        random.nextGaussian(), random.nextGaussian())));
    }

    private static JsonNode replay(Path log, long until) throws Exception {
        Outcome outcome = Reve.run("replay", log.toString(), "--until", Long.toString(until),
                "--json");
        assertThat(outcome.code()).as(outcome.out() + outcome.err()).isZero();
        return new JsonMapper().readTree(outcome.out());
    }
}
