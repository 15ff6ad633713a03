// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import reve.core.file.PackException;
import reve.core.file.WorldFileException;
import reve.core.plugin.PluginException;
import reve.core.urdf.RobotFileException;
import reve.pe.PhysicsException;

import java.net.BindException;

/** Exit codes of every command. The help text prints them. */
public final class ExitCode {
    /** The command succeeded. */
    public static final int OK = 0;

    /** The command failed. */
    public static final int FAILURE = 1;

    /** The command line is wrong. */
    public static final int USAGE = 2;

    /** The world file contains errors. */
    public static final int INVALID_WORLD = 3;

    /** A law or the engine could not be loaded. */
    public static final int PHYSICS = 4;

    /** The port is in use, or the address requires tokens and TLS. */
    public static final int CANNOT_BIND = 5;

    /** A world made no frame within the watchdog's time. */
    public static final int STALLED = 6;

    /**
     * Ctrl-C or SIGTERM has ended the command before its work was complete. Shells report this exit
     * code for SIGINT.
     */
    public static final int INTERRUPTED = 128 + 2;

    /**
     * The reader of the output has closed the pipe. Shells report this exit code for a program that
     * was ended by SIGPIPE.
     */
    public static final int CLOSED_PIPE = 128 + 13;

    private ExitCode() {}

    /** Returns the exit code of a command that ends with this failure. */
    public static int of(Throwable failure) {
        return switch (failure) {
            case PluginException unfit -> USAGE;
            case WorldFileException invalid -> INVALID_WORLD;
            case PackException unfit -> INVALID_WORLD;
            case RobotFileException invalid -> INVALID_WORLD;
            case PhysicsException physics -> PHYSICS;
            case BindException bind -> CANNOT_BIND;
            default -> FAILURE;
        };
    }
}
