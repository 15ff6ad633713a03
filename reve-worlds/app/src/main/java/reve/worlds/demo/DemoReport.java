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

    /** Prints the report for human readers, in sentences. */
    public void print(PrintWriter out) {
        out.printf(
                Locale.ROOT,
                "%nThe world %s ran for %.1f s of world time (%d frames), at %.2f x real time.%n",
                text(server, "world"),
                server.path("worldSeconds").asDouble(),
                server.path("frames").asLong(),
                server.path("realTimeFactor").asDouble());
        out.printf(
                Locale.ROOT,
                "The law %s was added while the world ran, at %.2f s, and removed at %.2f s. At the"
                        + " end the laws were %s.%n",
                text(loaded, "library"),
                loaded.path("time").asDouble(),
                unloaded.path("time").asDouble(),
                server.path("laws")
                        .valueStream()
                        .map(law -> text(law, "law"))
                        .collect(Collectors.joining(", ")));
        out.printf(
                Locale.ROOT,
                "The Python agent %s perceived the world %s and pushed items %s.%s%n",
                text(curious, "agent"),
                times(curious.path("perceptions").asLong()),
                times(curious.path("pushes").asLong()),
                refused(curious));
        out.printf(
                Locale.ROOT,
                "The Java agent %s perceived the world %s and painted items %s%s. The"
                        + " fastest item moved at %.1f m/s.%s%n",
                text(painter, "agent"),
                times(painter.path("perceptions").asLong()),
                times(painter.path("actsAccepted").asLong()),
                painter.path("painted")
                        .propertyStream()
                        .map(each -> each.getKey() + " is now " + each.getValue().asString())
                        .reduce((all, next) -> all + ", " + next)
                        .map(colours -> ": " + colours)
                        .orElse(""),
                painter.path("fastestMetresPerSecond").asDouble(),
                refused(painter));
        printPicture(out, "without", before);
        printPicture(out, "with", after);
    }

    private static String text(JsonNode node, String field) {
        return node.path(field).asString();
    }

    private static String times(long count) {
        return count == 1 ? "once" : count + " times";
    }

    private static String refused(JsonNode agent) {
        long count = agent.path("actsRefused").valueStream().mapToLong(JsonNode::asLong).sum();
        return count == 0 ? "" : " The server refused " + count + " of its actions.";
    }

    private void printPicture(PrintWriter out, String how, JsonNode picture) {
        out.printf(
                Locale.ROOT,
                "The picture at %.2f s, %s %s, is %s%n",
                picture.path("time").asDouble(),
                how,
                text(loaded, "library"),
                text(picture, "file"));
    }
}
