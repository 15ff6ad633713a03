// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.List;
import java.util.function.IntFunction;

/** A program that joins a run of an experiment as an agent. */
public final class AgentProgram {
    private final String name;
    private final IntFunction<List<String>> command;

    AgentProgram(String name, IntFunction<List<String>> command) {
        this.name = name;
        this.command = command;
    }

    /** Returns the name with which the program joins as an agent. */
    public String name() {
        return name;
    }

    /** Returns the command line that starts the program for a server on this TCP port. */
    public List<String> command(int port) {
        return command.apply(port);
    }
}
