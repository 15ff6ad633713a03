// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Option;

import reve.agent.AgentClient;

import java.io.IOException;
import java.util.Optional;

/** The options by which a command reaches a running world as a client of the role control. */
final class ControlTarget extends ServerTarget {
    @Option(
            names = "--world",
            paramLabel = "NAME",
            description = "Name of the world, if the server has several.")
    private Optional<String> world = Optional.empty();

    /**
     * Connects with the role control.
     *
     * @throws IOException if no server listens there
     * @throws reve.agent.AgentException if the server refuses the client
     */
    AgentClient connect() throws IOException {
        return connect(world);
    }

    /** Connects like {@link #connect()}, to this world unless the user names one. */
    AgentClient connectTo(Optional<String> otherwise) throws IOException {
        return connect(world.or(() -> otherwise));
    }
}
