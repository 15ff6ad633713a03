// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.EnumSource;

import reve.core.Seed;

import tools.jackson.databind.JsonNode;

import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Random;

/** Independent libraries read the encoded messages, and find the same content. */
class MessageWriterTest {

    private static final List<Object> EDGES =
            List.of(
                    "",
                    "plain",
                    "\"\\\b\f\n\r\t\u0000\u001f/\u007f",
                    "é€😀",
                    "é".repeat(15),
                    "x".repeat(31),
                    "x".repeat(32),
                    "x".repeat(255),
                    "x".repeat(256),
                    "😀".repeat(20_000),
                    0,
                    -1,
                    -32,
                    -33,
                    127,
                    128,
                    255,
                    256,
                    -128,
                    -129,
                    65_535,
                    65_536,
                    Integer.MIN_VALUE,
                    Integer.MAX_VALUE,
                    1L << 31,
                    (1L << 32) - 1,
                    1L << 32,
                    Long.MIN_VALUE,
                    Long.MAX_VALUE,
                    0.0,
                    -0.0,
                    1e-320,
                    Double.MIN_VALUE,
                    Double.MAX_VALUE,
                    1e21,
                    0.1,
                    true,
                    false,
                    List.of(),
                    Map.of(),
                    Collections.nCopies(15, 1),
                    Collections.nCopies(16, 1),
                    Collections.nCopies(70_000, "x"));

    private static JsonNode read(Encoding encoding, byte[] bytes) {
        return encoding == Encoding.JSON
                ? Json.MAPPER.readTree(new String(bytes, StandardCharsets.UTF_8))
                : MessagePackReader.read(ByteBuffer.wrap(bytes));
    }

    private static void assertReadAsWritten(Encoding encoding, Object value) {
        JsonNode read = read(encoding, encoding.value(writer -> writer.value(value)));
        assertSame(read, value);
    }

    private static void assertSame(JsonNode read, Object value) {
        switch (value) {
            case String text -> assertThat(read.stringValue()).isEqualTo(text);
            case Boolean truth -> assertThat(read.booleanValue()).isEqualTo(truth);
            case Double number -> assertThat(read.doubleValue()).isEqualTo(number);
            case Number number -> assertThat(read.longValue()).isEqualTo(number.longValue());
            case List<?> list -> {
                assertThat(read.isArray() && read.size() == list.size()).isTrue();
                for (int i = 0; i < list.size(); i++) {
                    assertSame(read.get(i), list.get(i));
                }
            }
            case Map<?, ?> map -> {
                assertThat(read.isObject() && read.size() == map.size()).isTrue();
                map.forEach((name, field) -> assertSame(read.get((String) name), field));
            }
            default -> throw new AssertionError(value);
        }
    }

    @ParameterizedTest
    @EnumSource
    void valuesAtTheLimitsOfTheirFormsAreReadAsTheyWereWritten(Encoding encoding) {
        EDGES.forEach(value -> assertReadAsWritten(encoding, value));
        var fields = new LinkedHashMap<String, Object>();
        for (int i = 0; i < 17; i++) {
            fields.put("field " + i, EDGES.get(i));
            assertReadAsWritten(encoding, fields);
        }
    }

    @ParameterizedTest
    @EnumSource
    void randomValuesAreReadAsTheyWereWritten(Encoding encoding) {
        long seed = Seed.of("values in " + encoding);
        var random = new Random(seed);
        for (int i = 0; i < 2000; i++) {
            assertReadAsWritten(encoding, any(random, 4));
        }
    }

    @Test
    void aFragmentIsWrittenAsItsValueWould() {
        var list = new Fragment(writer -> writer.value(List.of(1, "a")));
        for (Encoding encoding : Encoding.values()) {
            JsonNode read =
                    read(
                            encoding,
                            encoding.value(
                                    writer -> {
                                        writer.beginMap(2);
                                        writer.key("first");
                                        writer.fragment(list);
                                        writer.key("second");
                                        writer.fragment(list);
                                        writer.endMap();
                                    }));
            assertThat(read).hasToString("{\"first\":[1,\"a\"],\"second\":[1,\"a\"]}");
        }
    }

    private static Object any(Random random, int depth) {
        return switch (random.nextInt(depth > 0 ? 6 : 4)) {
            case 0 -> text(random);
            case 1 -> random.nextLong() >> random.nextInt(Long.SIZE);
            case 2 -> (random.nextDouble() - 0.5) * Math.pow(10, random.nextInt(-300, 300));
            case 3 -> random.nextBoolean();
            case 4 -> {
                var list = new ArrayList<Object>();
                for (int i = random.nextInt(20); i > 0; i--) {
                    list.add(any(random, depth - 2));
                }
                yield list;
            }
            default -> {
                var map = new LinkedHashMap<String, Object>();
                for (int i = random.nextInt(20); i > 0; i--) {
                    map.put(text(random), any(random, depth - 2));
                }
                yield map;
            }
        };
    }

    private static String text(Random random) {
        var text = new StringBuilder();
        for (int i = random.nextInt(40); i > 0; i--) {
            int limit = random.nextBoolean() ? 0x80 : Character.MAX_CODE_POINT + 1;
            int point = random.nextInt(limit);
            boolean half = point >= Character.MIN_SURROGATE && point <= Character.MAX_SURROGATE;
            text.appendCodePoint(half ? 'x' : point);
        }
        return text.toString();
    }
}
