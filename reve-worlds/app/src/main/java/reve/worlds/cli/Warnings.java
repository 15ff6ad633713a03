// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;

import reve.core.file.Problem;

import java.io.PrintWriter;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/** Printer of the problems that were found in a world. */
final class Warnings {
    private Warnings() {}

    /** Prints warnings to standard error, one line each, and returns them. */
    static List<Problem> print(CommandSpec spec, List<Problem> warnings) {
        PrintWriter err = spec.commandLine().getErr();
        warnings.forEach(err::println);
        err.flush();
        return warnings;
    }

    /** Returns the fields of problems for JSON. */
    static List<Map<String, Object>> fields(List<Problem> problems) {
        return problems.stream().map(Warnings::fields).toList();
    }

    /** Returns the fields of a problem for JSON. */
    static Map<String, Object> fields(Problem problem) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("file", problem.file());
        fields.put("line", problem.line());
        fields.put("column", problem.column());
        fields.put("pointer", problem.pointer());
        fields.put("message", problem.message());
        return fields;
    }
}
