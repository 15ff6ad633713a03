// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.agent.embodiment.Outcome;
import reve.core.agent.net.Outbox;
import reve.core.agent.net.RateLimitedLog;
import reve.core.agent.perception.EventSubjects;
import reve.core.agent.perception.HeardEvent;
import reve.core.agent.perception.Observatory;
import reve.core.agent.perception.PerceptionShares;
import reve.core.agent.perception.View;
import reve.core.agent.port.Cameras;
import reve.core.agent.port.WorldPort;
import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.publish.Perceiver;
import reve.core.agent.publish.PerceptionRequests;
import reve.core.agent.publish.Publisher;
import reve.core.derive.DerivedColumns;
import reve.core.frame.CommandQueue;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.OffHeapArena;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.BitSet;
import java.util.List;
import java.util.Optional;
import java.util.Set;
import java.util.concurrent.atomic.AtomicLong;
import java.util.concurrent.atomic.LongAdder;
import java.util.function.BooleanSupplier;

/** Clients whose look at a frame needs several slices of the event loop's time. */
class LookInSlicesTest {
    private final OffHeapArena arena = new OffHeapArena();
    private final World world = new World("pond", WorldPrototype.standard("si-f64"), arena);
    private final FrameBus bus = new FrameBus();
    private final FrameLoop loop = new FrameLoop(world, bus, Timing.DEFAULT, Pacing.FAST);

    /** The time, so that a busy machine does not end a slice. */
    private final AtomicLong nanos = new AtomicLong();

    /** Time that passes between two looks at the clock [ns]. */
    private long pace = 1;

    private final Publisher publisher = publisher();

    /** A client that perceives every frame. */
    private static final class Looker implements Perceiver {
        private final String name;
        private final boolean lockStep;
        private final PerceptionShares.Cost cost;
        private final LongAdder served = new LongAdder();
        private final PerceptionRequests requests =
                new PerceptionRequests(new Outbox(2, 1000, () -> {}), served);

        /** The frame that each look has read. */
        private final List<Long> looks = new ArrayList<>();

        /** Number of slices that the next look needs. */
        private int slices;

        private boolean senses = true;

        Looker(String name, boolean lockStep, int slices, Publisher publisher) throws BadMessage {
            this.name = name;
            this.lockStep = lockStep;
            this.slices = slices;
            cost = publisher.shares().cost(Optional.empty());
            requests.ask(new ClientMessage.Perceive(1, 1, false), 0);
            publisher.admit(this);
        }

        @Override
        public Optional<View> look(Observatory world, BooleanSupplier isTimeLeft) {
            looks.add(world.everything().frame());
            slices--;
            return slices > 0 ? Optional.empty() : Optional.of(world.everything());
        }

        @Override
        public String name() {
            return name;
        }

        @Override
        public Optional<String> body() {
            return Optional.empty();
        }

        @Override
        public Encoding encoding() {
            return Encoding.JSON;
        }

        @Override
        public PerceptionRequests perceptions() {
            return requests;
        }

        @Override
        public PerceptionShares.Cost perceptionCost() {
            return cost;
        }

        @Override
        public boolean isInLockStep() {
            return lockStep;
        }

        @Override
        public boolean perceives(long frame) {
            return requests.isDue(frame);
        }

        @Override
        public boolean wantsRelations(long frame) {
            return requests.wantsRelations(frame);
        }

        @Override
        public boolean hasSensors() {
            return senses;
        }

        @Override
        public Optional<Set<ItemId>> sensedIn(long frame) {
            return Optional.empty();
        }

        @Override
        public View relate(View view, Optional<Set<ItemId>> fresh) {
            return view;
        }

        @Override
        public boolean needsSight() {
            return false;
        }

        @Override
        public Optional<BitSet> hear(
                WorldEvent event, EventSubjects subjects, Observatory all, boolean searches) {
            return Optional.empty();
        }

        @Override
        public boolean reach(Observatory all, double[] lows, double[] highs, int at) {
            return false;
        }

        @Override
        public void embodied(Outcome outcome) {}

        @Override
        public void tell(HeardEvent.Told event) {}

        @Override
        public void miss(long events, long first, long last) {}
    }

    private Publisher publisher() {
        var commands = new CommandQueue(8);
        commands.subscribeTo(bus);
        DerivedColumns.subscribeTo(bus);
        var snapshots = new SnapshotRing(world, 3);
        bus.subscribe(
                FramePhase.PUBLISH,
                "snapshots",
                event -> snapshots.publish(event.frame(), event.timeSeconds()));
        var port =
                new WorldPort(
                        "pond",
                        60,
                        AgentRoom.making(),
                        bus,
                        commands,
                        snapshots,
                        loop,
                        new RoomControl(world, loop),
                        Cameras.none());
        return new Publisher(
                port,
                new RateLimitedLog(1, "looks"),
                () -> {},
                () -> {},
                () -> nanos.addAndGet(pace));
    }

    @BeforeEach
    void open() {
        world.add(AgentRoom.duck());
        bus.subscribe(
                FramePhase.PUBLISH, "publisher", event -> publisher.onFrame(event, List.of()));
    }

    @AfterEach
    void close() {
        arena.close();
    }

    private void step() {
        loop.step();
    }

    @ParameterizedTest
    @ValueSource(booleans = {false, true})
    void aLongLookGoesOnInItsFrameAndTheOthersReceiveNewerFrames(boolean lockStep)
            throws BadMessage {
        var ada = new Looker("ada", lockStep, 4, publisher);
        var bob = new Looker("bob", false, 0, publisher);
        step();
        publisher.tell();
        assertThat(ada.looks).as("a first slice").containsExactly(1L);
        assertThat(publisher.hasWork()).isTrue();
        publisher.tell();
        publisher.tell();
        assertThat(ada.looks).containsExactly(1L, 1L, 1L);
        assertThat(bob.looks).containsExactly(1L);
        step();
        publisher.tell();
        assertThat(bob.looks).as("the newer frame").containsExactly(1L, 2L);
        assertThat(ada.looks).containsExactly(1L, 1L, 1L, 1L);
        assertThat(ada.served.sum()).isOne();
        assertThat(bob.served.sum()).isEqualTo(2);
        publisher.tell();
        assertThat(ada.looks).as("then the newest frame").containsExactly(1L, 1L, 1L, 1L, 2L);
        assertThat(ada.served.sum()).isEqualTo(2);
        publisher.tell();
        assertThat(publisher.hasWork()).isFalse();
    }

    /** The event loop serves other worlds between two slices. */
    @Test
    void newItemsAreEncodedInSlicesBeforeTheirFrameIsServed() throws BadMessage {
        var bob = observer();
        addStones("stone ");
        pace = 1_000_000;
        int slices = 0;
        for (int turn = 0; turn < 100 && bob.looks.isEmpty(); turn++) {
            step();
            publisher.tell();
            slices++;
            assertThat(publisher.hasWork()).isTrue();
        }
        assertThat(bob.looks).as("the frame with the new items").containsExactly(1L);
        assertThat(slices).as("16 items between two looks at the clock").isBetween(12, 30);
        publisher.tell();
        assertThat(bob.looks).as("then the newest frame").containsExactly(1L, (long) slices);
        publisher.tell();
        assertThat(publisher.hasWork()).isFalse();

        pace = 1;
        world.find("stone 7").orElseThrow().semantic().set("note", "black");
        step();
        publisher.tell();
        assertThat(bob.looks).as("one new symbol is no work").hasSize(3);
    }

    private Looker observer() throws BadMessage {
        var bob = new Looker("bob", false, 0, publisher);
        bob.senses = false;
        return bob;
    }

    private void addStones(String name) {
        for (int i = 0; i < 1000; i++) {
            world.add(ItemDefinition.named(name + i).symbol("note", "grey").build());
        }
    }

    @Test
    void aWorldThatEndsSendsItsLastFrame() throws BadMessage {
        var bob = observer();
        addStones("stone ");
        pace = 1_000_000;
        step();
        publisher.tell();
        step();
        publisher.tellAll();
        assertThat(bob.looks).containsExactly(1L, 2L);
        assertThat(publisher.hasWork()).isFalse();
    }

    /** In each frame, new items are encoded, while newer frames are made. */
    @Test
    void longLooksBeginWhileNewItemsAreEncoded() throws BadMessage {
        var ada = new Looker("ada", false, 4, publisher);
        observer();
        for (int i = 0; i < 10; i++) {
            addStones("stone " + i + "-");
            pace = 1_000_000;
            for (int turn = 0; turn < 40; turn++) {
                step();
                publisher.tell();
            }
            pace = 1;
            ada.slices = 4;
        }
        assertThat(ada.served.sum()).isGreaterThan(5);
    }

    @ParameterizedTest
    @ValueSource(booleans = {false, true})
    void aSecondLongLookBeginsWhenTheFirstIsComplete(boolean lockStep) throws BadMessage {
        var ada = new Looker("ada", lockStep, 4, publisher);
        var bob = new Looker("bob", lockStep, 4, publisher);
        step();
        publisher.tell();
        assertThat(ada.looks.size() + bob.looks.size()).as("looks in one turn").isOne();
        int before = 1;
        for (int turn = 0; turn < 8; turn++) {
            publisher.tell();
            int looks = ada.looks.size() + bob.looks.size();
            assertThat(looks - before).as("looks in turn %d", turn).isLessThanOrEqualTo(2);
            before = looks;
        }
        assertThat(ada.looks).containsExactly(1L, 1L, 1L, 1L);
        assertThat(bob.looks).containsExactly(1L, 1L, 1L, 1L);
        assertThat(ada.served.sum()).isOne();
        assertThat(bob.served.sum()).isOne();
    }

    @ParameterizedTest
    @ValueSource(booleans = {false, true})
    void theLookOfAClientThatHasLeftEnds(boolean lockStep) throws BadMessage {
        var ada = new Looker("ada", lockStep, 1000, publisher);
        step();
        publisher.tell();
        publisher.tell();
        var bob = new Looker("bob", false, 1, publisher);
        step();
        publisher.dismiss(ada);
        publisher.tell();
        assertThat(ada.looks).containsExactly(1L, 1L);
        assertThat(bob.looks).containsExactly(2L);
        publisher.tell();
        assertThat(publisher.hasWork()).isFalse();
    }

    @Test
    void aClientWhoseLooksHaveBecomeShortIsServedAsOthersAgain() throws BadMessage {
        var ada = new Looker("ada", false, 2, publisher);
        for (int frame = 1; frame <= 12; frame++) {
            step();
            publisher.tell();
            publisher.tell();
        }
        assertThat(ada.looks).contains(11L, 12L);
        var bob = new Looker("bob", false, 1000, publisher);
        for (int frame = 13; frame <= 20; frame++) {
            step();
            publisher.tell();
            publisher.tell();
        }
        assertThat(bob.looks).as("a long look").hasSizeGreaterThan(8);
        assertThat(ada.looks).as("the frames during bob's look").contains(18L, 19L, 20L);
    }
}
