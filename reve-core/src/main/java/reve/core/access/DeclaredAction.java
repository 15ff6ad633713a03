package reve.core.access;

import java.util.HashSet;
import java.util.List;
import java.util.Set;
import reve.core.world.Action;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Parameter;

/**
 * An action made of {@link Effect}s, as world files declare them. All effects happen or none.
 * Immutable.
 */
public record DeclaredAction(String name, String doc, List<Parameter> parameters,
        List<Effect> effects) implements Action {

    /** @throws IllegalArgumentException if two effects change the same */
    public DeclaredAction {
        parameters = List.copyOf(parameters);
        effects = List.copyOf(effects);
        Set<String> changed = new HashSet<>();
        for (Effect effect : effects) {
            if (!changed.add(effect.changes())) {
                throw new IllegalArgumentException("action " + name
                        + " has two effects that change " + effect.changes());
            }
        }
    }

    @Override
    public void perform(ActionCall call) throws ActionRefused {
        Runnable[] changes = new Runnable[effects.size()];
        for (int i = 0; i < changes.length; i++) {
            changes[i] = effects.get(i).prepare(call);
        }
        for (Runnable change : changes) {
            change.run();
        }
    }
}
