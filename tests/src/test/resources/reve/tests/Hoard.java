// SPDX-License-Identifier: Apache-2.0
package example;

import reve.core.access.ActionProvider;
import reve.core.access.Effect;
import reve.core.world.ActionCall;

import java.util.ArrayList;
import java.util.List;

/** Allocates all memory. */
public final class Hoard implements ActionProvider {
    @Override
    public String name() {
        return "example.hoard";
    }

    @Override
    public String doc() {
        return "Takes all the memory.";
    }

    @Override
    public List<Effect> decide(ActionCall call) {
        List<long[]> kept = new ArrayList<>();
        while (true) {
            kept.add(new long[100_000]);
        }
    }
}
