// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import reve.core.file.WorldFileException;
import reve.pe.PhysicsException;

import java.net.BindException;

/** Exit codes of every command; printed in the help text. */
public final class ExitCode {
    public static final int OK = 0;
    public static final int FAILURE = 1;
    public static final int USAGE = 2;
    public static final int INVALID_WORLD = 3;
    public static final int PHYSICS = 4;
    public static final int CANNOT_BIND = 5;
    public static final int STALLED = 6;

    /** What shells report of a program that the signal SIGPIPE has ended. */
    public static final int CLOSED_PIPE = 128 + 13;

    private ExitCode() {}

    /** The code that a command ending with this failure exits with. */
    public static int of(Throwable failure) {
        return switch (failure) {
            case WorldFileException invalid -> INVALID_WORLD;
            case PhysicsException physics -> PHYSICS;
            case BindException bind -> CANNOT_BIND;
            default -> FAILURE;
        };
    }
}
