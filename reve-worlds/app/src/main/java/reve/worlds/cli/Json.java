// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;

import reve.core.text.Visible;

import tools.jackson.databind.json.JsonMapper;

import java.io.PrintWriter;
import java.util.Map;

/** Writer of results as JSON on standard output. */
public final class Json {
    private static final JsonMapper MAPPER = new JsonMapper();

    private Json() {}

    /** Returns the fields as one line of JSON, without a line end. */
    public static String line(Map<String, ?> fields) {
        return Visible.json(MAPPER.writeValueAsString(fields));
    }

    /** Returns a value as JSON on several lines, for people. */
    static String text(Object value) {
        return Visible.json(MAPPER.writerWithDefaultPrettyPrinter().writeValueAsString(value));
    }

    /** Prints one document to the command's standard output. */
    static void print(CommandSpec spec, Map<String, ?> fields) {
        PrintWriter out = spec.commandLine().getOut();
        out.print(
                Visible.json(MAPPER.writerWithDefaultPrettyPrinter().writeValueAsString(fields))
                        + System.lineSeparator());
        out.flush();
    }
}
