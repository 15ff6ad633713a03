// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThatCode;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;

/** The room of agents for symbols, with a clock that the test sets. */
class SymbolBudgetTest {
    private static final int FRAMES_PER_SECOND = 10;
    private static final long MOST = SymbolBudget.OF_AGENT;

    private final OffHeapArena arena = new OffHeapArena();
    private final World world = new World("w", WorldPrototype.standard("si-f64"), arena);
    private final SymbolBudget budget = new SymbolBudget(FRAMES_PER_SECOND);

    @AfterEach
    void close() {
        arena.close();
    }

    private void take(String agent, long frame, long bytes) throws ActionRefused {
        budget.require(world, agent, frame, bytes);
        budget.take(agent, frame, bytes);
    }

    private void assertRefused(String agent, long frame, long bytes, String message) {
        assertThatThrownBy(() -> budget.require(world, agent, frame, bytes))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining(message);
    }

    @Test
    void eachAgentHasItsOwnRoom() throws Exception {
        take("ada", 1, MOST - 10);
        take("ada", 1, 10);
        assertRefused("ada", 1, 1, "have taken 1048576 of their 1048576 bytes");
        take("bob", 1, MOST);
        assertThatCode(() -> budget.require(world, null, 1, 2 * MOST)).doesNotThrowAnyException();
    }

    @Test
    void whatIsShortenedGivesRoomBackButNoMoreThanWasTaken() throws Exception {
        take("ada", 1, MOST);
        budget.take("ada", 2, -100);
        take("ada", 2, 100);
        assertRefused("ada", 2, 1, "have taken 1048576");
        budget.take("ada", 3, -2 * MOST);
        assertRefused("ada", 3, MOST + 1, "have taken 0");
        take("ada", 3, MOST);
    }

    @Test
    void roomBecomesFreeWithTime() throws Exception {
        take("ada", 5, MOST);
        assertRefused("ada", 5 + FRAMES_PER_SECOND - 1, 1, "have taken 1048576");
        take("ada", 5 + FRAMES_PER_SECOND, SymbolBudget.PER_SECOND);
        assertRefused("ada", 5 + FRAMES_PER_SECOND, 1, "have taken 1048576");
        long all = MOST / SymbolBudget.PER_SECOND * FRAMES_PER_SECOND;
        take("ada", 5 + FRAMES_PER_SECOND + all, MOST);
    }

    @Test
    void anAgentThatActsInEachFrameGetsItsRoomBackToo() throws Exception {
        take("ada", 0, MOST / 2);
        for (int frame = 1; frame <= 100 * FRAMES_PER_SECOND; frame++) {
            take("ada", frame, 1);
        }
        long taken = MOST / 2 + 100 * FRAMES_PER_SECOND - 100 * SymbolBudget.PER_SECOND;
        assertRefused("ada", 100 * FRAMES_PER_SECOND, MOST, "have taken " + taken + " of");
    }

    /** Agents without tokens have any number of names. */
    @Test
    void manyNamesAreForgottenWhenTheyHaveTheirRoomAgain() throws Exception {
        for (int i = 0; i < 5_000; i++) {
            take("agent " + i, i * FRAMES_PER_SECOND, SymbolBudget.PER_SECOND);
        }
        take("agent 1", 5_000 * FRAMES_PER_SECOND, MOST);
        assertRefused("agent 1", 5_000 * FRAMES_PER_SECOND, 1, "have taken 1048576");
    }
}
