// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.rule.Rules;
import reve.core.world.Action;
import reve.core.world.ActionCall;
import reve.core.world.Arguments;
import reve.core.world.Item;
import reve.core.world.OffHeapArena;
import reve.core.world.World;

import java.nio.charset.StandardCharsets;
import java.util.Map;
import java.util.Optional;

/** The texts that other threads read about the work of the world's thread. */
@Timeout(600)
class ActivityTest {
    private static final String FILE =
            """
            reve: 1
            name: kitchen
            rules: {crowded: "semantic.near.all(n, n != 'x') && physics.mass > 1"}
            items:
              - name: pot
                physical: {location: [1, 0, 0]}
                physics: {mass: 2}
                access:
                  heat: {when: "[1, 2, 3].all(n, n < 4)", effects: [{symbol: hot, to: $1 + 2}]}
                  lift: {java: test.levitate}
            """;

    private final OffHeapArena arena = new OffHeapArena();
    private final WorldDescription description = description();
    private final World world = description.build(arena);
    private final FrameLoop loop =
            new FrameLoop(world, new FrameBus(), new Timing(60, 1), Pacing.FAST);

    private static WorldDescription description() {
        try {
            return WorldFile.parse("kitchen", FILE.getBytes(StandardCharsets.UTF_8));
        } catch (Exception refused) {
            throw new IllegalArgumentException(refused);
        }
    }

    @AfterEach
    void free() {
        arena.close();
    }

    /** Repeats the work until another thread has read that text. */
    private void assertSeen(String text, Runnable work) throws InterruptedException {
        Thread observer =
                Thread.ofPlatform()
                        .daemon()
                        .start(
                                () -> {
                                    while (!text.equals(
                                            String.valueOf(loop.activity().current()))) {
                                        Thread.onSpinWait();
                                    }
                                });
        while (observer.isAlive()) {
            work.run();
        }
        assertThat(loop.activity().current()).isNull();
    }

    private void perform(String action, Map<String, Object> arguments) {
        Item pot = world.find("pot").orElseThrow();
        try {
            Action of = pot.access().find(action).orElseThrow();
            new ActionCall(world, 1, pot, Optional.empty(), Arguments.check(of, arguments))
                    .perform(of);
        } catch (Exception refused) {
            throw new IllegalStateException(refused);
        }
    }

    @Test
    void otherThreadsSeeWhichRuleIsEvaluatedForWhichItem() throws Exception {
        Rules rules = new Rules(world, description.rules(), description.ruleSteps());

        assertSeen(
                "rule crowded of pot: `semantic.near.all(n, n != 'x') && physics.mass > 1`",
                () -> rules.update(1));
    }

    @Test
    void otherThreadsSeeWhichConditionIsEvaluated() throws Exception {
        assertSeen(
                "condition `[1, 2, 3].all(n, n < 4)` of an action of pot",
                () -> perform("heat", Map.of()));
    }

    @Test
    void otherThreadsSeeWhichValueIsEvaluated() throws Exception {
        assertSeen("value `1 + 2` of an action of pot", () -> perform("heat", Map.of()));
    }

    @Test
    void otherThreadsSeeWhichJavaActionDecides() throws Exception {
        assertSeen("action test.levitate of pot", () -> perform("lift", Map.of("by", 0)));
    }
}
