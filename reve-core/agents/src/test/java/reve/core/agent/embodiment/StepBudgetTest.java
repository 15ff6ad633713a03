// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

/** Limits of the steps that agents may take in a frame. */
class StepBudgetTest {

    private static final int DEAR = 20_000;
    private static final int CHEAP = 50;

    private final StepBudget budget = new StepBudget();

    /**
     * Acts as often in a frame as permitted, at most that often.
     *
     * @return number of acts
     */
    private int acts(String agent, long frame, int steps, int most) {
        int acts = 0;
        while (acts < most && budget.hasLeft(agent, frame)) {
            budget.spend(agent, frame, steps);
            acts++;
        }
        return acts;
    }

    private int acts(int agents, long first, int frames, int steps) {
        int acts = 0;
        for (int i = 0; i < frames; i++) {
            for (int agent = 0; agent < agents; agent++) {
                acts += acts("agent-" + agent, first + i, steps, 64);
            }
        }
        return acts;
    }

    @Test
    void aLoneAgentMayTakeAllThatOneEvaluationMayInEachFrame() {
        assertThat(acts(1, 1, 200, DEAR)).isBetween(198, 200);
    }

    @Test
    void cheapActsDoNotWait() {
        acts(1, 1, 1, CHEAP);
        assertThat(acts(1, 2, 100, CHEAP)).as("64 in each frame").isEqualTo(6400);
    }

    @Test
    void manyAgentsTogetherTakeWhatAFrameHas() {
        int frames = 1000;
        long steps = (long) acts(50, 1, frames, DEAR) * (DEAR + StepBudget.OF_ACT);
        assertThat(steps)
                .isBetween(
                        (long) (0.9 * frames * StepBudget.OF_FRAME),
                        (long) (1.1 * frames * StepBudget.OF_FRAME));
    }

    @Test
    void anAgentOfCheapActsDoesNotWaitForThoseOfDearOnes() {
        acts("innocent", 1, CHEAP, 1);
        for (long frame = 2; frame <= 1000; frame++) {
            acts(100, frame, 1, DEAR);
            assertThat(acts("innocent", frame, CHEAP, 3)).as("frame %d", frame).isEqualTo(3);
        }
    }

    @Test
    void turnsAndPausesGainNothing() {
        int acts = 0;
        for (long frame = 1; frame <= 2000; frame += 40) { // all of them at once, then none
            acts += acts(50, frame, 1, DEAR);
        }
        assertThat((long) acts * DEAR).isLessThan((long) (1.3 * 2000 * StepBudget.OF_FRAME));
    }

    @Test
    void stepsThatAnActCausesLaterAreADebtToo() {
        acts("ann", 1, CHEAP, 1);
        budget.charge("ann", 2, 10 * StepBudget.MOST);
        long frame = 2;
        while (!budget.hasLeft("ann", frame)) {
            frame++;
        }
        assertThat(frame).isBetween(10L, 13L);
    }

    @Test
    void stepsThatNewAgentsCauseAreTakenFromWhatNewAgentsShare() {
        int acts = 0;
        for (long frame = 1; frame <= 1000; frame++) {
            String name = "new-" + frame;
            if (budget.hasLeft(name, frame)) {
                budget.spend(name, frame, CHEAP);
                budget.charge(name, frame + 1, 10 * StepBudget.MOST);
                acts++;
            }
        }
        assertThat(acts).isBetween(90, 110);
    }

    @Test
    void cheapActsOfANewAgentDoNotWait() {
        assertThat(acts("new", 1, CHEAP, 64)).isEqualTo(64);
    }

    @Test
    void comingUnderOtherNamesGainsNothing() {
        int acts = 0;
        for (long frame = 1; frame <= 1000; frame++) {
            for (int i = 0; i < 20; i++) {
                acts += acts("agent-" + frame + "-" + i, frame, DEAR, 1);
            }
        }
        assertThat(acts).as("one evaluation in each frame").isBetween(990, 1010);
    }

    @Test
    void whoHasActedBeforeDoesNotWaitForNewcomers() {
        acts("innocent", 1, CHEAP, 1);
        for (long frame = 2; frame <= 1000; frame++) {
            for (int i = 0; i < 20; i++) {
                acts("agent-" + frame + "-" + i, frame, DEAR, 1);
            }
            assertThat(acts("innocent", frame, CHEAP, 3)).as("frame %d", frame).isEqualTo(3);
        }
    }
}
