// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import java.nio.file.Path;
import java.util.Optional;

/**
 * The native laws that run in a sandbox: a process that can access only the columns that its laws
 * declare.
 *
 * @param folder the folder of laws that the operator does not trust
 * @param worlds true if untrusted native code that comes with a world, a store or a recording runs
 *     in a sandbox; false if such code is refused
 * @param weakly true if laws run in a sandbox even on a machine that lacks a layer of the sandbox;
 *     false if they are then refused
 */
public record Sandboxed(Optional<Path> folder, boolean worlds, boolean weakly) {
    /** The value for a server in which no law runs in a sandbox. */
    public static final Sandboxed NONE = new Sandboxed(Optional.empty(), false, false);

    /** Returns whether laws may run in a sandbox. */
    public boolean isUsed() {
        return folder.isPresent() || worlds;
    }
}
