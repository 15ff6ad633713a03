// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Parameter;
import reve.core.world.PerformableAction;

import java.util.List;

/**
 * An action that consists of {@link Effect}s, which a world file declares. Either all effects are
 * applied or none. Immutable.
 */
public record DeclaredAction(
        String name, String doc, List<Parameter> parameters, Terms terms, List<Effect> effects)
        implements PerformableAction {

    /**
     * Checks that the effects do not contradict each other.
     *
     * @throws IllegalArgumentException if two effects change the same value
     */
    public DeclaredAction {
        parameters = List.copyOf(parameters);
        effects = List.copyOf(effects);
        Changes.requireCompatible(name, effects);
    }

    /** Creates an action without conditions or required capabilities. */
    public DeclaredAction(
            String name, String doc, List<Parameter> parameters, List<Effect> effects) {
        this(name, doc, parameters, Terms.NONE, effects);
    }

    @Override
    public List<String> needs() {
        return terms.needs();
    }

    @Override
    public void perform(ActionCall call) throws ActionRefused {
        terms.require(this, call);
        Changes.prepare(call, effects).make();
    }
}
