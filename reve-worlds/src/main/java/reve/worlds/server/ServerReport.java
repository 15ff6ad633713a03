package reve.worlds.server;

import java.io.PrintWriter;
import java.util.LinkedHashMap;
import java.util.Locale;
import java.util.Map;
import reve.core.agent.AgentStats;

/** What a server's run came to: the world's part and the agents'. */
public record ServerReport(RunReport run, AgentStats agents) {
    /** For JSON; the caller may add to it. */
    public Map<String, Object> fields() {
        Map<String, Object> fields = new LinkedHashMap<>(run.fields());
        Map<String, Object> agentFields = new LinkedHashMap<>();
        agentFields.put("joined", agents.joined());
        agentFields.put("perceptions", agents.perceptions());
        agentFields.put("actsAccepted", agents.actsAccepted());
        agentFields.put("actsRefused", agents.actsRefused());
        agentFields.put("errors", agents.errors());
        agentFields.put("cut", agents.cut());
        fields.put("agents", agentFields);
        return fields;
    }

    /** A few lines for people. */
    public void print(PrintWriter out) {
        run.print(out);
        out.printf(Locale.ROOT, "agents: %d joined, %d perceptions, %d acts accepted, %d refused, %d cut%n",
                agents.joined(), agents.perceptions(), agents.actsAccepted(), agents.actsRefused(), agents.cut());
    }
}
