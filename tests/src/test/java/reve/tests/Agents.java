// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import reve.agent.AgentClient;
import reve.agent.Join;

import java.io.IOException;
import java.time.Duration;

/** Agents of tests. They are patient, because other tests may occupy the machine for seconds. */
final class Agents {
    private static final Duration PATIENCE = Duration.ofMinutes(2);

    private Agents() {}

    /** Joins the only world of a server of this machine. */
    static AgentClient join(int port, String name) throws IOException {
        return join(port, Join.as(name));
    }

    /** Joins a world of a server of this machine. */
    static AgentClient join(int port, Join join) throws IOException {
        return join("127.0.0.1", port, join);
    }

    /** Joins a world of a server. */
    static AgentClient join(String host, int port, Join join) throws IOException {
        return AgentClient.connect(host, port, join.withPatience(PATIENCE));
    }
}
