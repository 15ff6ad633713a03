// SPDX-License-Identifier: Apache-2.0
package reve.worlds.export;

import tools.jackson.core.JsonGenerator;
import tools.jackson.databind.json.JsonMapper;

import java.io.ByteArrayOutputStream;
import java.util.List;

/** One message in JSON that is being written. For one thread. */
final class JsonText {
    private static final JsonMapper JSON = new JsonMapper();
    private static final long SECOND_NANOS = 1_000_000_000L;
    private static final List<String> AXES = List.of("x", "y", "z", "w");
    private static final List<String> CHANNELS = List.of("r", "g", "b", "a");

    private final ByteArrayOutputStream bytes = new ByteArrayOutputStream();
    private final JsonGenerator out = JSON.createGenerator(bytes);

    /** Begins the object of the message. */
    JsonText() {
        out.writeStartObject();
    }

    JsonText begin(String name) {
        out.writeName(name);
        out.writeStartObject();
        return this;
    }

    JsonText begin() {
        out.writeStartObject();
        return this;
    }

    JsonText end() {
        out.writeEndObject();
        return this;
    }

    JsonText beginList(String name) {
        out.writeName(name);
        out.writeStartArray();
        return this;
    }

    JsonText endList() {
        out.writeEndArray();
        return this;
    }

    JsonText put(String name, String value) {
        out.writeStringProperty(name, value);
        return this;
    }

    JsonText put(String name, boolean value) {
        out.writeBooleanProperty(name, value);
        return this;
    }

    JsonText put(String name, double value) {
        out.writeNumberProperty(name, value);
        return this;
    }

    JsonText put(String name, long value) {
        out.writeNumberProperty(name, value);
        return this;
    }

    /** Writes a number whose digits the caller has already converted to text. */
    JsonText digits(String name, String number) {
        out.writeName(name);
        out.writeNumber(number);
        return this;
    }

    JsonText time(String name, long nanos) {
        return begin(name).put("sec", nanos / SECOND_NANOS).put("nsec", nanos % SECOND_NANOS).end();
    }

    /** Writes three or four numbers as x, y, z and w. */
    JsonText vector(String name, double... values) {
        begin(name);
        for (int i = 0; i < values.length; i++) {
            put(AXES.get(i), values[i]);
        }
        return end();
    }

    /** Writes a colour, given as in {@link reve.core.world.Colour#rgba()}. */
    JsonText colour(String name, int rgba) {
        return begin(name).channels(rgba).end();
    }

    /** Writes the parts of a colour as r, g, b and a. */
    JsonText channels(int rgba) {
        for (int i = 0; i < CHANNELS.size(); i++) {
            put(CHANNELS.get(i), (rgba >>> 8 * i & 0xff) / 255.0);
        }
        return this;
    }

    /** Ends the message and returns it in UTF-8. */
    byte[] done() {
        out.writeEndObject();
        out.close();
        return bytes.toByteArray();
    }
}
