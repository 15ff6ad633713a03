// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Server.Events;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.io.InputStream;
import java.net.InetAddress;
import java.net.Socket;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Random;

/**
 * Invalid files in the laws folder and invalid data on the port of a running server. Each causes
 * one message and has no other effect.
 */
@Tag("slow")
class BrokenInputIT {
    private static final String WORLD = Project.WORLDS.resolve("spring-orbit").toString();

    private static final int TIMEOUT_MILLISECONDS = 120_000;

    @TempDir private Path folder;

    @Test
    void rubbishGetsOneMessageEachAndCostsTheWorldNothing() throws Exception {
        Path laws = Files.createDirectory(folder.resolve("laws"));
        Path ready = Files.createDirectory(folder.resolve("ready"));
        Files.writeString(ready.resolve("text.so"), "this is no library");
        compile("no_law.c", ready.resolve("no_law.so"));
        compile("other_abi.c", ready.resolve("other_abi.so"));
        compile("nan_writer.cpp", ready.resolve("nan_writer.so"));
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        WORLD,
                        "--port",
                        "0",
                        "--laws",
                        laws.toString(),
                        "--json")) {
            Events events = server.events();
            int port = events.await("ready", line -> true).get("agentPort").asInt();
            for (String file : List.of("text.so", "no_law.so", "other_abi.so", "nan_writer.so")) {
                Files.move(ready.resolve(file), laws.resolve(file));
            }
            sendGarbage(port);

            assertThat(fault(events, "text.so")).contains("not an ELF file");
            assertThat(fault(events, "no_law.so")).contains("vesper_law_library_entry");
            assertThat(fault(events, "other_abi.so")).contains("7.3").contains("1.2");
            JsonNode nan =
                    events.await(
                            "fault",
                            line -> line.path("library").asString("").equals("nan_writer"));
            assertThat(nan.path("law").asString()).isEqualTo("nan_writer");
            assertThat(nan.path("property").asString()).isEqualTo("velocity");
            assertThat(nan.path("item").asString()).isEqualTo("blue");
            assertThat(nan.path("message").asString()).contains("velocity").contains("row 1");

            server.process().toHandle().destroy();
            JsonNode end = events.await("end", line -> true);
            assertThat(end.get("faults").size())
                    .as("one message each: " + end.get("faults"))
                    .isEqualTo(4);
            assertThat(end.at("/profile/redoneFrames").asInt()).isEqualTo(1);
            assertThat(server.exitCode()).isZero();
            assertThat(end.get("stateHash"))
                    .as("state of a world that nobody disturbed")
                    .isEqualTo(undisturbed(end.get("frames").asLong()));
        }
    }

    private static JsonNode undisturbed(long frames) throws Exception {
        String seconds = Double.toString(frames / 60.0);
        String report = Reve.run("run", WORLD, "--seconds", seconds, "--json").out();
        return new JsonMapper().readTree(report).get("stateHash");
    }

    private static String fault(Events events, String file) throws Exception {
        return events.await("fault", line -> line.path("file").asString("").equals(file))
                .get("message")
                .asString();
    }

    /**
     * Sends lines of garbage. The server answers each line with an error or a bye with a code, and
     * others can still join.
     */
    private static void sendGarbage(int port) throws IOException {
        long seed = System.nanoTime();
        System.out.println("garbage seed " + seed);
        Random random = new Random(seed);
        List<byte[]> lines =
                new ArrayList<>(
                        List.of(
                                bytes("GET / HTTP/1.1\r\n"),
                                bytes("{\"t\":\"hello\",\"protocol\":99,\"name\":\"x\"}\n"),
                                bytes(
                                        "{\"t\":\"act\",\"id\":1,\"item\":\"red\",\"action\":\"paint\"}\n")));
        byte[] noise = new byte[300];
        random.nextBytes(noise);
        noise[299] = '\n';
        lines.add(noise);
        for (byte[] line : lines) {
            try (Socket socket = new Socket(InetAddress.getLoopbackAddress(), port)) {
                socket.setSoTimeout(TIMEOUT_MILLISECONDS);
                socket.getOutputStream().write(line);
                InputStream in = socket.getInputStream();
                String answer = new String(in.readNBytes(12), StandardCharsets.UTF_8);
                assertThat(answer).startsWith("{\"t\":\"").matches("\\{\"t\":\"(error|bye).*");
            }
        }
        try (Socket socket = new Socket(InetAddress.getLoopbackAddress(), port)) {
            socket.setSoTimeout(TIMEOUT_MILLISECONDS);
            socket.getOutputStream()
                    .write(bytes("{\"t\":\"hello\",\"protocol\":1,\"name\":\"good\"}\n"));
            assertThat(new String(socket.getInputStream().readNBytes(14), StandardCharsets.UTF_8))
                    .isEqualTo("{\"t\":\"welcome\"");
        }
    }

    private static byte[] bytes(String line) {
        return line.getBytes(StandardCharsets.UTF_8);
    }

    private void compile(String source, Path library) throws Exception {
        Path file = folder.resolve(source);
        try (InputStream text = BrokenInputIT.class.getResourceAsStream(source)) {
            Files.write(file, text.readAllBytes());
        }
        Path built = folder.resolve("built.so");
        boolean cpp = source.endsWith(".cpp");
        Process compiler =
                new ProcessBuilder(
                                cpp ? "g++" : "gcc",
                                cpp ? "-std=c++20" : "-std=c11",
                                "-shared",
                                "-fPIC",
                                "-O1",
                                "-fvisibility=hidden",
                                "-I" + Project.ROOT.resolve("vesper-native/include"),
                                file.toString(),
                                "-o",
                                built.toString())
                        .redirectErrorStream(true)
                        .start();
        String said = new String(compiler.getInputStream().readAllBytes(), StandardCharsets.UTF_8);
        assertThat(compiler.waitFor()).as(said).isZero();
        Files.move(built, library);
    }
}
