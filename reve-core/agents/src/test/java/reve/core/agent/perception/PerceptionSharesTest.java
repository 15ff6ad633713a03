// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import java.util.ArrayList;
import java.util.List;
import java.util.Optional;

/** Costs and times are inputs of this test. Therefore each run has the same results. */
class PerceptionSharesTest {
    private static final long MILLISECOND = 1_000_000;

    private final PerceptionShares<Perceiver> shares = new PerceptionShares<>(0);
    private final List<Perceiver> all = new ArrayList<>();
    private long now;

    private record Perceiver(
            String name, PerceptionShares.Cost perceptionCost, boolean isInLockStep)
            implements PerceptionShares.Client {

        @Override
        public boolean perceives(long frame) {
            return true;
        }
    }

    private Perceiver perceiver(String name) {
        var perceiver = new Perceiver(name, shares.cost(Optional.empty()), false);
        all.add(perceiver);
        return perceiver;
    }

    /** Lets a client perceive and writes to it, which takes that much time in total. */
    private void serve(Perceiver client, long nanos) {
        shares.serve(client.perceptionCost(), nanos / 2);
        client.perceptionCost().wrote(nanos - nanos / 2);
    }

    private void pass(long nanos) {
        now += nanos;
        shares.begin(all, 1, now);
    }

    @Test
    void whoPerceivesCheaplyIsServedAtOnceBesideManyWhoDoNot() {
        Perceiver cheap = perceiver("cheap");
        for (int i = 0; i < 300; i++) {
            serve(perceiver("dear-" + i), 50 * MILLISECOND);
        }
        serve(cheap, 20_000);
        pass(300 * 17 * MILLISECOND);
        assertThat(shares.isServedNow(cheap)).isTrue();
        for (Perceiver other : all.subList(1, all.size())) {
            assertThat(shares.isServedNow(other)).as(other.name()).isFalse();
        }
        assertThat(shares.waiting()).hasSize(300);
    }

    @Test
    void whoOwesLeastComesFirstAndWhoPaidIsServedAtOnce() {
        Perceiver dear = perceiver("dear");
        Perceiver dearer = perceiver("dearer");
        serve(dearer, 40 * MILLISECOND);
        serve(dear, 20 * MILLISECOND);
        pass(20 * MILLISECOND);
        assertThat(shares.isServedNow(dearer)).isFalse();
        assertThat(shares.isServedNow(dear)).isFalse();
        assertThat(shares.waiting()).containsExactly(dear, dearer);
        pass(20 * MILLISECOND);
        assertThat(shares.isServedNow(dear)).as("two shares of 10 ms paid 20 ms").isTrue();
        assertThat(shares.isServedNow(dearer)).isFalse();
    }

    @Test
    void theSessionsOfOneTokenHaveOneShare() {
        var many = new ArrayList<Perceiver>();
        for (int i = 0; i < 50; i++) {
            many.add(new Perceiver("many-" + i, shares.cost(Optional.of("class")), false));
        }
        all.addAll(many);
        Perceiver alone = perceiver("alone");
        many.forEach(one -> serve(one, MILLISECOND));
        serve(alone, MILLISECOND);
        pass(2 * MILLISECOND);
        assertThat(shares.isServedNow(alone)).as("half of 2 ms pays 1 ms").isTrue();
        assertThat(many).noneMatch(shares::isServedNow);
    }

    @Test
    void aSliceEndsWhenWhatIsExpectedFillsIt() {
        for (int i = 0; i < 100; i++) {
            perceiver("new-" + i);
        }
        pass(MILLISECOND);
        all.forEach(shares::isServedNow);
        int served = 0;
        for (Perceiver next : shares.waiting()) {
            if (!shares.isTimeLeft()) {
                break;
            }
            serve(next, 1000);
            served++;
        }
        assertThat(served).as("first perceptions are taken to cost 1 ms, of 10 ms").isEqualTo(10);
        pass(MILLISECOND);
        assertThat(shares.isTimeLeft()).isTrue();
    }

    @Test
    void whoIsInLockStepIsServedAtOnceHoweverDear() {
        var learner = new Perceiver("learner", shares.cost(Optional.empty()), true);
        all.add(learner);
        serve(learner, 500 * MILLISECOND);
        pass(MILLISECOND);
        assertThat(shares.isServedNow(learner)).isTrue();
    }
}
