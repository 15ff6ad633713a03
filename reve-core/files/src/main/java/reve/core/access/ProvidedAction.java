// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Parameter;
import reve.core.world.PerformableAction;

import java.util.List;
import java.util.ServiceLoader;

/** An action whose effects an {@link ActionProvider} decides. Immutable. */
public record ProvidedAction(String name, String doc, Terms terms, ActionProvider provider)
        implements PerformableAction {

    /**
     * Returns all providers on the class path, in the order of the class path.
     *
     * @throws java.util.ServiceConfigurationError if one cannot be loaded
     */
    public static List<ActionProvider> providers() {
        return ServiceLoader.load(ActionProvider.class).stream()
                .map(ServiceLoader.Provider::get)
                .toList();
    }

    @Override
    public List<Parameter> parameters() {
        return provider.parameters();
    }

    @Override
    public List<String> needs() {
        return terms.needs();
    }

    @Override
    public void perform(ActionCall call) throws ActionRefused {
        terms.require(this, call);
        Changes changes;
        try {
            List<Effect> effects = decide(call);
            Changes.requireCompatible(name, effects);
            changes = Changes.prepare(call, effects);
        } catch (RuntimeException | LinkageError | StackOverflowError failed) {
            throw new ActionRefused(
                    "action-failed", "action " + provider.name() + " failed", failed);
        }
        changes.make();
    }

    private List<Effect> decide(ActionCall call) throws ActionRefused {
        String what = "action " + provider.name();
        call.world().activity().begin(what + " of " + call.target().name());
        try {
            return List.copyOf(call.world().guard().inspect(what, () -> provider.decide(call)));
        } finally {
            call.world().activity().end();
        }
    }
}
