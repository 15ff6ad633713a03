// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import reve.core.file.RunPoint;

import tools.jackson.databind.JsonNode;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;

/**
 * Codec of the result of a run as JSON. A result that was written and read is identical, bit by
 * bit.
 */
final class RunRecord {
    static final String RUN = "run";

    /** Key of a number that JSON cannot represent, such as NaN. */
    private static final String NUMBER = "number";

    private RunRecord() {}

    /** Returns the fields of a result. */
    static Map<String, Object> fields(RunResult result) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put(RUN, result.point().number());
        fields.put("state", result.state().name());
        fields.put("message", result.message());
        fields.put("frames", result.frames());
        fields.put("stateHash", result.stateHash());
        fields.put("values", wrapped(result.values()));
        fields.put("expected", wrapped(result.expected()));
        fields.put("notes", result.notes());
        fields.put("laws", result.laws());
        List<Object> samples = new ArrayList<>();
        for (Sample sample : result.samples()) {
            samples.add(List.of(sample.frame(), sample.timeSeconds(), wrapped(sample.values())));
        }
        fields.put("samples", samples);
        return fields;
    }

    /**
     * Returns a list for each value. It contains the value, or is empty if the value is missing.
     */
    private static List<Object> wrapped(List<? extends Optional<?>> values) {
        List<Object> all = new ArrayList<>();
        values.forEach(value -> all.add(value.map(RunRecord::written).stream().toList()));
        return all;
    }

    private static Object written(Object value) {
        return switch (value) {
            case Double number when !Double.isFinite(number) ->
                    Map.of(NUMBER, Double.toString(number));
            case List<?> list -> list.stream().map(RunRecord::written).toList();
            default -> value;
        };
    }

    /**
     * Reads the result of a run.
     *
     * @param point the values of this run
     * @throws IllegalArgumentException if the fields are not those of a result
     */
    static RunResult read(JsonNode fields, RunPoint point) {
        List<Sample> samples = new ArrayList<>();
        for (JsonNode sample : fields.path("samples")) {
            samples.add(
                    new Sample(
                            sample.path(0).asLong(),
                            sample.path(1).asDouble(),
                            values(sample.path(2))));
        }
        List<Optional<Double>> expected = new ArrayList<>();
        for (Optional<Object> value : values(fields.path("expected"))) {
            expected.add(value.map(Double.class::cast));
        }
        Map<String, String> laws = new LinkedHashMap<>();
        for (String name : fields.path("laws").propertyNames()) {
            laws.put(name, fields.path("laws").path(name).asString());
        }
        List<String> notes = new ArrayList<>();
        fields.path("notes").forEach(note -> notes.add(note.asString()));
        return new RunResult(
                point,
                RunResult.State.valueOf(fields.path("state").asString("").toUpperCase(Locale.ROOT)),
                fields.path("message").asString(),
                fields.path("frames").asLong(),
                fields.path("stateHash").asString(),
                samples,
                values(fields.path("values")),
                expected,
                notes,
                laws);
    }

    private static List<Optional<Object>> values(JsonNode list) {
        List<Optional<Object>> values = new ArrayList<>();
        for (JsonNode value : list) {
            values.add(value.isEmpty() ? Optional.empty() : Optional.of(value(value.path(0))));
        }
        return values;
    }

    private static Object value(JsonNode value) {
        if (value.isObject()) {
            return Double.valueOf(value.path(NUMBER).asString());
        }
        if (value.isArray()) {
            List<Object> list = new ArrayList<>();
            value.forEach(element -> list.add(value(element)));
            return list;
        }
        return value.isNumber()
                ? (Object) value.doubleValue()
                : value.isBoolean() ? (Object) value.booleanValue() : value.asString();
    }
}
