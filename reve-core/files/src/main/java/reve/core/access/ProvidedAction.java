// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Parameter;
import reve.core.world.PerformableAction;
import reve.core.world.ProviderFaults;

import java.util.List;

/** An action whose effects an {@link ActionProvider} decides. Immutable. */
public record ProvidedAction(String name, String doc, Terms terms, ActionProvider provider)
        implements PerformableAction {

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
        } catch (RuntimeException | Error failed) {
            ProviderFaults.requireBearable(failed);
            call.world()
                    .providerFaults()
                    .report(
                            call.frame(),
                            "ACT",
                            "action " + provider.name(),
                            provider,
                            failed,
                            "the act was refused (reported once)");
            throw new ActionRefused(
                    "action-failed", "action " + provider.name() + " failed", failed);
        } finally {
            ProviderFaults.clearInterrupt();
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
