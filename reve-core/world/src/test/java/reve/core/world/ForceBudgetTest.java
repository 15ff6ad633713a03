// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatCode;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.Test;

class ForceBudgetTest {

    private final ForceBudget budget = new ForceBudget();

    private void exert(String agent, long frame, long frames) throws ActionRefused {
        budget.require(agent, frame, 1);
        budget.take(agent, frame, frames);
    }

    @Test
    void forcesThatHaveEndedNoLongerCount() throws Exception {
        for (int frame = 1; frame <= 100 * ForceBudget.OF_AGENT; frame++) {
            exert("ann", frame, ForceBudget.OF_AGENT);
        }
    }

    @Test
    void allAgentsTogetherHaveALimit() throws Exception {
        int agents = ForceBudget.OF_ALL / ForceBudget.OF_AGENT;
        for (int agent = 0; agent < agents; agent++) {
            for (int i = 0; i < ForceBudget.OF_AGENT; i++) {
                exert("agent-" + agent, 1, 60);
            }
        }
        var refused = catchThrowableOfType(ActionRefused.class, () -> exert("bob", 60, 1));
        assertThat(refused.code()).isEqualTo("too-many-forces");
        assertThat(refused).hasMessageContaining("10000 of at most 10000 forces of actions of all");
        exert("bob", 61, 1);
    }

    @Test
    void actionsOfNobodyAndARewoundWorldAreNotLimited() throws Exception {
        for (int i = 0; i <= ForceBudget.OF_AGENT; i++) {
            exert(null, 5, 1000);
        }
        for (int i = 0; i < ForceBudget.OF_AGENT; i++) {
            exert("ann", 5, 1000);
        }
        assertThatCode(() -> exert("ann", 4, 1000)).doesNotThrowAnyException();
    }
}
