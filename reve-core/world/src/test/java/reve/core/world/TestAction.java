// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;

/** An action in Java, as a designer may write one. */
public record TestAction(String name, String doc, Deed deed) implements PerformableAction {

    private static final Deed NOTHING = call -> {};

    /** What it does. */
    public interface Deed {
        void perform(ActionCall call) throws ActionRefused;
    }

    /** An action that does nothing. */
    public TestAction(String name, String doc) {
        this(name, doc, NOTHING);
    }

    @Override
    public List<Parameter> parameters() {
        return List.of();
    }

    @Override
    public void perform(ActionCall call) throws ActionRefused {
        deed.perform(call);
    }
}
