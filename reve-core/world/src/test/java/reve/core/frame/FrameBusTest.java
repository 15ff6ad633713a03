// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;

import org.junit.jupiter.api.Test;

import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;

class FrameBusTest {

    private final World world =
            new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena());
    private final FrameBus bus = new FrameBus();
    private final FrameLoop loop = new FrameLoop(world, bus, Timing.DEFAULT, Pacing.FAST);
    private final List<String> calls = new ArrayList<>();

    private FrameListener note(String what) {
        return event -> calls.add(event.frame() + " " + event.phase() + " " + what);
    }

    @Test
    void phasesComeInOrderAndListenersInOrderOfSubscription() {
        bus.subscribe(FramePhase.PUBLISH, "p", note("p"));
        bus.subscribe(FramePhase.PHYSICS, "x", note("x"));
        bus.subscribe(FramePhase.ACT, "a2", note("a2"));
        bus.subscribe(FramePhase.ACT, "a1", note("a1"));
        bus.subscribe(FramePhase.INTAKE, "i", note("i"));
        bus.subscribe(FramePhase.DERIVE, "d", note("d"));
        loop.step();
        assertThat(calls)
                .containsExactly(
                        "0 DERIVE d",
                        "0 PUBLISH p",
                        "1 INTAKE i",
                        "1 ACT a2",
                        "1 ACT a1",
                        "1 PHYSICS x",
                        "1 DERIVE d",
                        "1 PUBLISH p");
    }

    @Test
    void aClosedSubscriptionIsNotCalledAgain() {
        Subscription a = bus.subscribe(FramePhase.ACT, "a", note("a"));
        bus.subscribe(FramePhase.ACT, "b", note("b"));
        a.close();
        a.close();
        loop.step();
        assertThat(calls).containsExactly("1 ACT b");
    }

    @Test
    void aListenerMaySubscribeAndCloseDuringAFrameWithEffectFromTheNextDispatch() {
        List<Subscription> own = new ArrayList<>();
        own.add(
                bus.subscribe(
                        FramePhase.ACT,
                        "once",
                        event -> {
                            calls.add("once");
                            own.getFirst().close();
                            bus.subscribe(FramePhase.ACT, "later", note("later"));
                        }));
        bus.subscribe(FramePhase.ACT, "always", note("always"));
        loop.step();
        loop.step();
        assertThat(calls).containsExactly("once", "1 ACT always", "2 ACT always", "2 ACT later");
    }

    @Test
    void physicsTakesOneListener() {
        Subscription first = bus.subscribe(FramePhase.PHYSICS, "vesper", note("v"));
        assertThatIllegalStateException()
                .isThrownBy(() -> bus.subscribe(FramePhase.PHYSICS, "other", note("o")))
                .withMessageContaining("vesper")
                .withMessageContaining("other");
        first.close();
        bus.subscribe(FramePhase.PHYSICS, "other", note("o"));
        loop.step();
        assertThat(calls).containsExactly("1 PHYSICS o");
    }

    @Test
    void aThrowingListenerHarmsNoOtherAndIsReportedOncePerMessage() {
        List<WorldEvent> faults = new ArrayList<>();
        bus.subscribe(
                FramePhase.ACT,
                "bad",
                event -> {
                    throw new IllegalStateException("broken " + event.frame() / 3);
                });
        bus.subscribe(FramePhase.ACT, "good", note("good"));
        bus.subscribe(FramePhase.PUBLISH, "reader", event -> faults.addAll(event.world().events()));
        for (int i = 0; i < 4; i++) {
            loop.step();
        }
        assertThat(calls).hasSize(4);
        assertThat(faults).extracting(WorldEvent::type).containsExactly("fault", "fault");
        assertThat(faults).extracting(WorldEvent::frame).containsExactly(1L, 3L);
        assertThat(faults.getFirst().fields())
                .containsEntry("phase", "ACT")
                .containsEntry("source", "bad")
                .containsEntry("error", "IllegalStateException")
                .containsEntry("message", "broken 0");
    }

    @Test
    void structureChangesInIntakeAndActAndIsRefusedElsewhere() {
        List<String> refused = new ArrayList<>();
        for (FramePhase phase : FramePhase.values()) {
            bus.subscribe(
                    phase,
                    "adder",
                    event -> {
                        try {
                            event.world()
                                    .add(
                                            ItemDefinition.named(
                                                            event.frame() + event.phase().name())
                                                    .build());
                        } catch (IllegalStateException e) {
                            assertThat(e).hasMessageContaining(event.phase().name());
                            refused.add(event.phase().name());
                        }
                    });
        }
        loop.step();
        assertThat(refused).containsExactly("DERIVE", "PUBLISH", "PHYSICS", "DERIVE", "PUBLISH");
        assertThat(world.find("1INTAKE")).isPresent();
        assertThat(world.find("1ACT")).isPresent();
        world.add(ItemDefinition.named("between frames").build());
    }

    @Test
    void eventsBelongToOneFrame() {
        List<String> seen = new ArrayList<>();
        world.raise(new WorldEvent(0, "built", Map.of()));
        bus.subscribe(
                FramePhase.ACT,
                "raiser",
                event -> event.world().raise(new WorldEvent(event.frame(), "acted", Map.of())));
        bus.subscribe(
                FramePhase.PUBLISH,
                "reader",
                event ->
                        event.world()
                                .events()
                                .forEach(raised -> seen.add(event.frame() + raised.type())));
        loop.step();
        world.raise(new WorldEvent(1, "between", Map.of()));
        loop.step();
        assertThat(seen).containsExactly("0built", "1acted", "2between", "2acted");
    }

    @Test
    void whatIsRaisedInPublishIsToldInTheNextFrameToAllReaders() {
        List<String> seen = new ArrayList<>();
        FrameListener reader =
                event ->
                        event.world()
                                .events()
                                .forEach(
                                        raised ->
                                                seen.add(
                                                        event.frame()
                                                                + " "
                                                                + raised.fields().get("message")));
        bus.subscribe(FramePhase.PUBLISH, "early reader", reader);
        bus.subscribe(
                FramePhase.PUBLISH,
                "bad",
                event -> {
                    if (event.frame() == 1) {
                        throw new IllegalStateException("disk full");
                    }
                });
        bus.subscribe(FramePhase.PUBLISH, "late reader", reader);
        loop.step();
        assertThat(seen).isEmpty();
        loop.step();
        assertThat(seen).containsExactly("2 disk full", "2 disk full");
        loop.step();
        assertThat(seen).hasSize(2);
    }
}
