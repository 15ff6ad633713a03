// SPDX-License-Identifier: Apache-2.0
package example;

import reve.core.access.ActionProvider;
import reve.core.access.Effect;
import reve.core.world.ActionCall;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;

/** Blocks the world's thread while a file exists. */
public final class Hang implements ActionProvider {
    @Override
    public String name() {
        return "example.hang";
    }

    @Override
    public String doc() {
        return "Hangs.";
    }

    @Override
    public List<Effect> decide(ActionCall call) {
        while (Files.exists(Path.of("hang"))) {
            Thread.onSpinWait();
        }
        return List.of();
    }
}
