// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.agent.AgentStats;

import java.io.PrintWriter;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;

/**
 * The result of a server's run, for its worlds and its agents.
 *
 * @param runs reports of the worlds that did not fail
 * @param worlds number of worlds
 * @param unkept messages about data that the stores lack
 * @param gaps messages about frames that the recordings lack
 */
public record ServerReport(
        List<RunReport> runs,
        int worlds,
        AgentStats agents,
        List<String> unkept,
        List<String> gaps) {
    /** Copies the lists. */
    public ServerReport {
        runs = List.copyOf(runs);
        unkept = List.copyOf(unkept);
        gaps = List.copyOf(gaps);
    }

    /**
     * Returns a copy of this report with messages about data that the stores and the recordings
     * lack.
     */
    public ServerReport lacking(List<String> inStores, List<String> inRecordings) {
        return new ServerReport(runs, worlds, agents, inStores, inRecordings);
    }

    /**
     * Returns true if a world failed, messages lack their audit record, a store lacks the end of
     * the run, or a recording lacks frames. Each of these failures was already reported as a fault
     * event when it happened.
     */
    public boolean failed() {
        return runs.size() < worlds
                || agents.unrecorded() > 0
                || !unkept.isEmpty()
                || !gaps.isEmpty();
    }

    /** Returns the fields for JSON; the caller may add fields. */
    public Map<String, Object> fields() {
        Map<String, Object> fields = new LinkedHashMap<>();
        if (worlds > 1) {
            fields.put("worlds", runs.stream().map(RunReport::fields).toList());
        } else {
            runs.forEach(run -> fields.putAll(run.fields()));
        }
        Map<String, Object> agentFields = new LinkedHashMap<>();
        agentFields.put("joined", agents.joined());
        agentFields.put("perceptions", agents.perceptions());
        agentFields.put("actsAccepted", agents.actsAccepted());
        agentFields.put("actsRefused", agents.actsRefused());
        agentFields.put("errors", agents.errors());
        agentFields.put("cut", agents.cut());
        agentFields.put("unrecorded", agents.unrecorded());
        fields.put("agents", agentFields);
        if (!unkept.isEmpty()) {
            fields.put("unkept", unkept);
        }
        if (!gaps.isEmpty()) {
            fields.put("gaps", gaps);
        }
        return fields;
    }

    /** Prints a summary for human readers. */
    public void print(PrintWriter out) {
        runs.forEach(run -> run.print(out));
        out.printf(
                Locale.ROOT,
                "agents: %d joined, %d perceptions, %d acts accepted, %d refused, %d cut%n",
                agents.joined(),
                agents.perceptions(),
                agents.actsAccepted(),
                agents.actsRefused(),
                agents.cut());
        if (agents.unrecorded() > 0) {
            out.printf(Locale.ROOT, "audit: %d messages have no record%n", agents.unrecorded());
        }
        unkept.forEach(message -> out.println("store: " + message));
        gaps.forEach(message -> out.println("recording: " + message));
    }
}
