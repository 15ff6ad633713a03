package example;

import java.util.ArrayList;
import java.util.List;
import reve.core.access.ActionProvider;
import reve.core.access.Effect;
import reve.core.world.ActionCall;

/** Takes all the memory that there is. */
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
