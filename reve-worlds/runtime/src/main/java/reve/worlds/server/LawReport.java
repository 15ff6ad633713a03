// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.pe.LawParameter;
import reve.pe.PhysicsLaw;
import reve.pe.PropertyUse;
import reve.pe.adapter.LawColumns;
import reve.pe.adapter.LawLibrary;
import reve.pe.adapter.LawTime;
import reve.pe.adapter.Laws;
import reve.pe.adapter.PhysicsAdapter;
import reve.pe.adapter.Quarantined;

import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.stream.IntStream;

/**
 * The report about the laws of a world for operators. It lists loaded, quarantined and available
 * laws.
 */
final class LawReport {
    private static final double NANOSECONDS = 1e9;

    private final LawEquations equations;
    private final LawTrust trust;

    /**
     * Creates an object that makes reports.
     *
     * @param equations equations of laws that were read
     * @param trust the reasons why laws are executed
     */
    LawReport(LawEquations equations, LawTrust trust) {
        this.equations = equations;
        this.trust = trust;
    }

    /**
     * Returns the report. For the world's thread only.
     *
     * @param available names of libraries that can be loaded
     * @param faults whether to include messages of faults, which may name files of the server
     * @param trials the trials of new versions, see {@link Shadows#report}
     */
    Map<String, Object> of(
            PhysicsAdapter physics,
            List<String> available,
            boolean faults,
            List<Map<String, Object>> trials) {
        Laws laws = physics.laws();
        Map<String, Object> content = new LinkedHashMap<>();
        List<Object> libraries = new ArrayList<>();
        List<PhysicsLaw> loaded = laws.loaded();
        List<LawTime> times = physics.lawTimes();
        laws.byId()
                .forEach(
                        (id, library) ->
                                libraries.add(
                                        library(
                                                library,
                                                laws.isApart(id),
                                                IntStream.range(0, loaded.size())
                                                        .filter(
                                                                i ->
                                                                        loaded.get(i).libraryId()
                                                                                == id)
                                                        .mapToObj(
                                                                i ->
                                                                        law(
                                                                                library,
                                                                                loaded.get(i),
                                                                                times.get(i)))
                                                        .toList())));
        content.put("loaded", libraries);
        content.put(
                "quarantined",
                laws.quarantined().stream().map(law -> quarantined(law, faults)).toList());
        content.put("available", available);
        if (!trials.isEmpty()) {
            content.put("trials", trials);
        }
        return content;
    }

    /** Returns the fields of laws' own columns in the report of an item; none if it has none. */
    static Map<String, Object> columns(LawColumns columns) {
        Map<String, Object> fields = new LinkedHashMap<>();
        if (!columns.columns().isEmpty()) {
            fields.put("lawColumns", columns.columns().stream().map(LawReport::column).toList());
        }
        if (columns.more() > 0) {
            fields.put("moreLawColumns", columns.more());
        }
        return fields;
    }

    private static Map<String, Object> column(LawColumns.Column column) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("library", column.library());
        fields.put("law", column.law());
        fields.put("name", column.name());
        fields.put(
                "value", column.components() == 1 ? column.values().getFirst() : column.values());
        fields.put("unit", column.unit());
        if (column.values().size() < column.components()) {
            fields.put("components", column.components());
        }
        return fields;
    }

    private static Map<String, Object> quarantined(Quarantined law, boolean faults) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("library", law.library());
        fields.put("sha256", law.sha256());
        fields.put("frame", law.frame());
        fields.put("status", law.status().name());
        if (faults) {
            fields.put("message", law.message());
        }
        return fields;
    }

    private Map<String, Object> library(
            LawLibrary library, boolean apart, List<Map<String, Object>> laws) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("library", library.name());
        fields.put("sha256", library.sha256());
        equations.of(library.name()).ifPresent(text -> fields.put("equation", text));
        if (library.isText()) {
            fields.put("text", new String(library.bytes(), StandardCharsets.UTF_8));
        }
        library.budget().ifPresent(budget -> fields.put("budget", budget.fields()));
        if (library.interval() != 1) {
            fields.put("interval", library.interval());
        }
        if (apart) {
            fields.put("apart", true);
        }
        fields.put("trust", trust.of(library, apart));
        fields.put("laws", laws);
        return fields;
    }

    private static Map<String, Object> law(LawLibrary library, PhysicsLaw law, LawTime time) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("name", law.name());
        fields.put("version", law.version());
        fields.put("doc", law.doc());
        fields.put("phase", law.phase().name().toLowerCase(Locale.ROOT));
        fields.put("calls", law.calls());
        fields.put("seconds", law.nanoseconds() / NANOSECONDS);
        fields.put("p50Seconds", time.medianNanoseconds() / NANOSECONDS);
        fields.put("p99Seconds", time.p99Nanoseconds() / NANOSECONDS);
        fields.put("share", time.share());
        if (law.resting()) {
            fields.put("resting", true);
        }
        fields.put("uses", law.uses().stream().map(LawReport::use).toList());
        fields.put(
                "parameters",
                law.parameters().stream()
                        .map(parameter -> parameter(library, law, parameter))
                        .toList());
        return fields;
    }

    private static Map<String, Object> use(PropertyUse use) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("name", use.name());
        fields.put("kind", use.kind());
        fields.put("type", use.type().name().toLowerCase(Locale.ROOT));
        fields.put("components", use.components());
        fields.put(
                "access",
                use.access().stream()
                        .sorted()
                        .map(access -> access.name().toLowerCase(Locale.ROOT))
                        .toList());
        fields.put("unit", use.unit().symbol());
        if (use.optional()) {
            fields.put("optional", true);
        }
        return fields;
    }

    private static Map<String, Object> parameter(
            LawLibrary library, PhysicsLaw law, LawParameter parameter) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("name", parameter.name());
        fields.put("doc", parameter.doc());
        fields.put("unit", parameter.unit().symbol());
        Map<String, Double> given = library.parameters();
        fields.put(
                "value",
                given.getOrDefault(
                        law.name() + "." + parameter.name(),
                        given.getOrDefault(parameter.name(), parameter.standard())));
        fields.put("default", parameter.standard());
        if (Double.isFinite(parameter.minimum())) {
            fields.put("min", parameter.minimum());
        }
        if (Double.isFinite(parameter.maximum())) {
            fields.put("max", parameter.maximum());
        }
        return fields;
    }
}
