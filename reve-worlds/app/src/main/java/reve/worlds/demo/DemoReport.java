// SPDX-License-Identifier: Apache-2.0
package reve.worlds.demo;

import tools.jackson.databind.JsonNode;

import java.io.PrintWriter;
import java.util.LinkedHashMap;
import java.util.Locale;
import java.util.Map;
import java.util.stream.Collectors;

/**
 * The result of the demonstration, as its three processes reported it.
 *
 * @param server the server's final report
 * @param loaded event that reports the loading of the added law
 * @param unloaded event that reports the removal of this law
 * @param before picture without the added law
 * @param after picture with the added law
 * @param curious the Python agent's summary
 * @param painter the Java agent's summary
 */
public record DemoReport(
        JsonNode server,
        JsonNode loaded,
        JsonNode unloaded,
        JsonNode before,
        JsonNode after,
        JsonNode curious,
        JsonNode painter) {
    /** Returns the report's fields for JSON. */
    public Map<String, Object> fields() {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("server", server);
        fields.put("lawLoaded", loaded);
        fields.put("lawUnloaded", unloaded);
        fields.put("pictures", new JsonNode[] {before, after});
        fields.put("pythonAgent", curious);
        fields.put("javaAgent", painter);
        return fields;
    }

    /** Prints the report for human readers. */
    public void print(PrintWriter out) {
        out.printf(
                Locale.ROOT,
                "%nworld     %s: %d frames, %.1f s of world time at %.2f x real time%n",
                server.path("world").asString(),
                server.path("frames").asLong(),
                server.path("worldSeconds").asDouble(),
                server.path("realTimeFactor").asDouble());
        out.printf(
                Locale.ROOT,
                "laws      %s; %s from %.2f s to %.2f s, dropped in while running%n",
                server.path("laws")
                        .valueStream()
                        .map(law -> law.path("law").asString())
                        .collect(Collectors.joining(", ")),
                loaded.path("library").asString(),
                loaded.path("time").asDouble(),
                unloaded.path("time").asDouble());
        printAgent(out, "Python", curious);
        printAgent(out, "Java", painter);
        printPicture(out, "before", before);
        printPicture(out, "after", after);
    }

    private static void printAgent(PrintWriter out, String language, JsonNode summary) {
        out.printf(Locale.ROOT, "agent     %s (%s)%n", summary.path("agent").asString(), language);
        summary.propertyStream()
                .filter(field -> !field.getKey().equals("agent"))
                .forEach(
                        field ->
                                out.printf(
                                        Locale.ROOT,
                                        "            %s: %s%n",
                                        field.getKey(),
                                        field.getValue()));
    }

    private static void printPicture(PrintWriter out, String when, JsonNode picture) {
        out.printf(
                Locale.ROOT,
                "picture   %-7s %.2f s: %s%n",
                when,
                picture.path("time").asDouble(),
                picture.path("file").asString());
    }
}
