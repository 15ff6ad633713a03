// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.Seed;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.Vectors;

import tools.jackson.databind.JsonNode;

import java.io.ByteArrayOutputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.HexFormat;

/** Runs Jazzer on the decoders, beginning with the protocol's vectors. */
@Tag("slow")
class DecoderFuzzIT {

    /** Number of inputs. A long run uses ten million. */
    private static final int RUNS = Integer.getInteger("reve.fuzz.runs", 5_000);

    /**
     * Disables libFuzzer's limit of memory. It compares the peak of the process that started the
     * fuzzer; the heap limit of the Java process bounds the memory instead.
     */
    private static final String NO_RSS_LIMIT = "-rss_limit_mb=0";

    @TempDir private Path folder;

    @Test
    void whateverArrivesIsUnderstoodOrRefused() throws Exception {
        Path corpus = Files.createDirectory(folder.resolve("corpus"));
        writeVectors(corpus);
        long seed = Seed.of("the decoder") & Integer.MAX_VALUE;
        Process jazzer =
                new ProcessBuilder(
                                System.getProperty("java.home") + "/bin/java",
                                "--enable-native-access=ALL-UNNAMED",
                                "--sun-misc-unsafe-memory-access=allow",
                                "-Xmx1g",
                                "-cp",
                                System.getProperty("java.class.path"),
                                "com.code_intelligence.jazzer.Jazzer",
                                "--target_class=" + DecoderFuzzer.class.getName(),
                                "--instrumentation_includes="
                                        + "reve.core.agent.**:tools.jackson.core.**:org.msgpack.**",
                                "-runs=" + RUNS,
                                "-seed=" + seed,
                                "-max_len=8192",
                                "-timeout=300",
                                NO_RSS_LIMIT,
                                corpus.toString())
                        .directory(folder.toFile())
                        .redirectErrorStream(true)
                        .start();
        jazzer.getOutputStream().close();
        String said = new String(jazzer.getInputStream().readAllBytes(), StandardCharsets.UTF_8);
        assertThat(jazzer.waitFor()).as("seed -Dreve.test.seed=%s%n%s", seed, said).isZero();
        assertThat(said).as("Jazzer ran").contains("Done " + RUNS + " runs");
    }

    private static void writeVectors(Path corpus) throws Exception {
        int number = 0;
        for (String file :
                new String[] {
                    "client.jsonl", "refused.jsonl", "packed.jsonl", "packed-refused.jsonl"
                }) {
            for (JsonNode vector : Vectors.lines(file)) {
                String line = vector.path("line").asString(vector.toString());
                byte[] frame =
                        vector.has("bytes")
                                ? HexFormat.of().parseHex(vector.get("bytes").stringValue())
                                : line.getBytes(StandardCharsets.UTF_8);
                boolean packed = file.startsWith("packed");
                int skipped = packed ? Math.min(frame.length, Encoding.LENGTH_BYTES) : 0;
                write(corpus.resolve("message" + number), packed ? 1 : 0, frame, skipped);
                write(
                        corpus.resolve("stream" + number),
                        (packed ? 3 : 2) + (number % 32 << 2),
                        frame,
                        0);
                number++;
            }
        }
    }

    private static void write(Path file, int first, byte[] bytes, int skipped) throws Exception {
        var input = new ByteArrayOutputStream();
        input.write(first);
        input.write(bytes, skipped, bytes.length - skipped);
        Files.write(file, input.toByteArray());
    }
}
