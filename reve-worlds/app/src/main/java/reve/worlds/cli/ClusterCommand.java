// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.AgentException;
import reve.core.text.Visible;

import java.io.IOException;
import java.io.PrintWriter;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/** The command {@code cluster}: shows the nodes and worlds of a cluster. */
@Command(
        name = "cluster",
        description = "Shows the nodes of a cluster, and on which of them each world runs.")
public final class ClusterCommand implements Runnable {
    @Spec private CommandSpec spec = CommandSpec.create();

    @Override
    public void run() {
        throw new ParameterException(spec.commandLine(), "expected status");
    }

    @Command(
            name = "status",
            description =
                    "Lists the nodes and worlds of a cluster, as one of its nodes knows them. If the"
                            + " cluster has several worlds, --world names any of them.")
    int status(
            @Mixin ControlTarget target,
            @Option(names = "--json", description = "Print the result as one JSON document.")
                    boolean json)
            throws IOException {
        try (AgentClient client = target.connect()) {
            ActResult result = client.command("cluster", Map.of());
            if (!result.accepted()) {
                throw new IOException(
                        result.code().orElse("refused") + ": " + result.reason().orElse(""));
            }
            Map<?, ?> state = (Map<?, ?>) result.value().orElseThrow();
            if (json) {
                Map<String, Object> fields = new LinkedHashMap<>();
                state.forEach((name, value) -> fields.put(String.valueOf(name), value));
                Json.print(spec, fields);
            } else {
                print(state);
            }
            return ExitCode.OK;
        } catch (AgentException refused) {
            throw target.refused(refused);
        }
    }

    private void print(Map<?, ?> state) {
        PrintWriter out = spec.commandLine().getOut();
        out.println(
                "cluster " + text(state, "cluster") + ", as " + text(state, "node") + " knows it");
        for (Object each : (List<?>) state.get("nodes")) {
            Map<?, ?> node = (Map<?, ?>) each;
            out.println(
                    "node "
                            + text(node, "node")
                            + ": "
                            + text(node, "status")
                            + ", worlds: "
                            + text(node, "worlds")
                            + ", agents at "
                            + text(node, "agents"));
        }
        for (Object each : (List<?>) state.get("worlds")) {
            Map<?, ?> world = (Map<?, ?>) each;
            out.println(
                    "world "
                            + text(world, "world")
                            + ": frame "
                            + text(world, "frame")
                            + ", epoch "
                            + text(world, "epoch")
                            + (world.containsKey("node")
                                    ? ", on " + text(world, "node")
                                    : ", on no node"));
        }
        out.flush();
    }

    private static String text(Map<?, ?> fields, String name) {
        return Visible.line(String.valueOf(fields.get(name)));
    }
}
