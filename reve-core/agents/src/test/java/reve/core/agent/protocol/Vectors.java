// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import static org.assertj.core.api.Assertions.assertThat;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.Objects;

/** The protocol's page and test vectors. Clients also use them. */
public final class Vectors {

    private static final JsonMapper JSON = new JsonMapper();

    private Vectors() {}

    public static List<JsonNode> lines(String file) {
        return text("vectors/" + file).lines().map(JSON::readTree).toList();
    }

    /** Compares JSON: the order of fields and the form of a number do not matter. */
    public static void assertSame(JsonNode actual, JsonNode expected) {
        assertThat(actual.equals(Vectors::compareLeaves, expected))
                .as("expected %s%n but was %s", expected, actual)
                .isTrue();
    }

    private static int compareLeaves(JsonNode a, JsonNode b) {
        if (a.isNumber() && b.isNumber()) {
            return Double.compare(a.doubleValue(), b.doubleValue());
        }
        return a.equals(b) ? 0 : 1;
    }

    public static String text(String file) {
        String root =
                Objects.requireNonNull(
                        System.getProperty("reve.root"),
                        "set -Dreve.root to the folder of the project");
        Path path = Path.of(root, "agents/protocol", file);
        try {
            return Files.readString(path);
        } catch (IOException e) {
            throw new AssertionError("cannot read " + path, e);
        }
    }
}
