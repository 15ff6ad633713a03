// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;

import reve.core.world.WorldChange.Aspect;
import reve.core.world.WorldChange.Edited;

import java.util.List;

class WorldChangeTest {

    private final World world =
            new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena());
    private final Item ball = world.add(ItemDefinition.named("ball").physics("mass", 2).build());
    private final Item lamp = world.add(ItemDefinition.named("lamp").build());

    @BeforeEach
    void beginFrame() {
        FrameControl.of(world).end();
    }

    @Test
    void tellsWhatCameAndWent() {
        var a = ItemDefinition.named("a").physics("mass", 1).build();
        var s =
                ItemDefinition.named("s")
                        .kind("spring")
                        .reference("end1", "a")
                        .reference("end2", "a")
                        .physics("length", 1)
                        .build();
        List<Item> added = world.addAll(List.of(s, a));
        world.remove(lamp.id());
        world.removeCascade(added.get(1).id());
        assertThat(world.changes())
                .containsExactly(
                        new WorldChange.Added(added.get(0).id(), List.of(s, a)),
                        new WorldChange.Removed(lamp.id(), "lamp", List.of()),
                        new WorldChange.Removed(
                                added.get(1).id(), "a", List.of(added.get(0).id())));
    }

    @Test
    void tellsNamesAndAttachments() {
        world.rename(lamp.id(), "torch");
        world.rename(lamp.id(), "torch");
        world.attach(lamp.id(), ball.id());
        world.attach(lamp.id(), ball.id(), new Pose(1, 0, 0, 0, 0, 0, 1));
        world.detach(lamp.id());
        var before = new Attachment(ball.id(), Pose.ORIGIN);
        var after = new Attachment(ball.id(), new Pose(1, 0, 0, 0, 0, 0, 1));
        assertThat(world.changes())
                .containsExactly(
                        new WorldChange.Renamed(lamp.id(), "lamp", "torch"),
                        new WorldChange.Attached(lamp.id(), null, before),
                        new WorldChange.Attached(lamp.id(), before, after),
                        new WorldChange.Detached(lamp.id(), after));
    }

    @Test
    void tellsForces() {
        var force = new Force(ball.id(), List.of(1.0, 2.0, 3.0), 4);
        world.forces().add(force);
        assertThat(world.changes()).containsExactly(new WorldChange.Pushed(force));
    }

    @Test
    void tellsEditsOfEveryAspectWithOldAndNewValue() {
        Action push = new TestAction("push", "At first.");
        Action harder = new TestAction("push", "Harder.");
        lamp.physical().setLocation(1, 2, 3);
        lamp.physical().setOrientation(0, 0, 2, 0);
        lamp.physical().setShape(Shape.sphere(1));
        lamp.physical().setColour(Colour.parse("#ff0000"));
        lamp.semantic().set("lit", true);
        lamp.semantic().remove("lit");
        lamp.semantic().remove("lit");
        lamp.access().set(push);
        lamp.access().set(harder);
        lamp.access().remove("push");
        ball.physics().set("mass", 3);
        lamp.physics().set("charge", 4);
        assertThat(world.changes())
                .containsExactly(
                        physical("location", List.of(0.0, 0.0, 0.0), List.of(1.0, 2.0, 3.0)),
                        physical(
                                "orientation",
                                List.of(0.0, 0.0, 0.0, 1.0),
                                List.of(0.0, 0.0, 1.0, 0.0)),
                        physical("shape", Shape.none(), Shape.sphere(1)),
                        physical("colour", Colour.DEFAULT, Colour.parse("#ff0000")),
                        new Edited(lamp.id(), Aspect.SEMANTIC, "lit", null, true),
                        new Edited(lamp.id(), Aspect.SEMANTIC, "lit", true, null),
                        new Edited(lamp.id(), Aspect.ACCESS, "push", null, push),
                        new Edited(lamp.id(), Aspect.ACCESS, "push", push, harder),
                        new Edited(lamp.id(), Aspect.ACCESS, "push", harder, null),
                        new Edited(ball.id(), Aspect.PHYSICS, "mass", List.of(2.0), List.of(3.0)),
                        new Edited(lamp.id(), Aspect.PHYSICS, "charge", null, List.of(4.0)));
    }

    @Test
    void tellsTheColourAndTheWidthOfASpring() {
        Item spring =
                world.add(
                        ItemDefinition.named("s")
                                .kind("spring")
                                .reference("end1", "ball")
                                .reference("end2", "ball")
                                .build());
        spring.physical().setColour(Colour.WHITE);
        spring.physical().setColour(Colour.DEFAULT);
        spring.physical().setWidth(0.5);
        assertThat(world.changes())
                .endsWith(
                        new Edited(spring.id(), Aspect.PHYSICAL, "colour", null, Colour.WHITE),
                        new Edited(
                                spring.id(),
                                Aspect.PHYSICAL,
                                "colour",
                                Colour.WHITE,
                                Colour.DEFAULT),
                        new Edited(spring.id(), Aspect.PHYSICAL, "width", 0.0, 0.5));
    }

    @Test
    void tellsWhereReferencesPointNow() {
        Item spring =
                world.add(
                        ItemDefinition.named("s")
                                .kind("spring")
                                .reference("end1", "ball")
                                .reference("end2", "ball")
                                .build());
        Item other = world.add(ItemDefinition.named("other").physics("mass", 1).build());
        FrameControl.of(world).end();
        spring.physics().setReferences("end2", other.id());
        assertThat(world.changes())
                .containsExactly(
                        new Edited(
                                spring.id(),
                                Aspect.PHYSICS,
                                "end2",
                                List.of(ball.id()),
                                List.of(other.id())));
    }

    @Test
    void takingAnItemOutOfPhysicsTellsEveryPropertyItHad() {
        int properties = ball.physics().properties().size();
        ball.physics().clear();
        assertThat(world.changes())
                .hasSize(properties)
                .contains(new Edited(ball.id(), Aspect.PHYSICS, "mass", List.of(2.0), null));
    }

    @Test
    void directWritesToAColumnAreToldOnceAFrame() {
        Column mass = world.table("body").column("mass");
        var told = new WorldChange.ColumnEdited("body", "mass");
        mass.setDouble(0, 0, 3);
        mass.setDouble(0, 0, 4);
        mass.touch();
        assertThat(world.changes()).containsExactly(told);
        FrameControl.of(world).publish();
        mass.setDouble(0, 0, 5);
        assertThat(world.changes()).containsExactly(told);
        FrameControl.of(world).end();
        assertThat(world.changes()).containsExactly(told);
        FrameControl.of(world).end();
        mass.touch();
        assertThat(world.changes()).containsExactly(told);
    }

    @Test
    void whatIsRefusedIsNotTold() {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.rename(lamp.id(), "ball"))
                .withMessage("item name ball is already taken");
        assertThatIllegalArgumentException().isThrownBy(() -> world.rename(lamp.id(), " "));
        assertThatIllegalArgumentException().isThrownBy(() -> world.rename(lamp.id(), "world"));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.rename(world.find("world").orElseThrow().id(), "earth"));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.physics().set("mass", Double.NaN));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> lamp.physical().setLocation(0, Double.NaN, 0));
        assertThatIllegalArgumentException().isThrownBy(() -> lamp.semantic().set("name", "torch"));
        assertThat(world.changes()).isEmpty();
    }

    @Test
    void aRenamedItemIsFoundByItsNewNameAndKeepsItsReferences() {
        Item spring =
                world.add(
                        ItemDefinition.named("s")
                                .kind("spring")
                                .reference("end1", "ball")
                                .reference("end2", "ball")
                                .build());
        world.rename(ball.id(), "globe");
        assertThat(world.find("ball")).isEmpty();
        assertThat(world.find("globe")).contains(ball);
        assertThat(ball.name()).isEqualTo("globe");
        assertThat(world.symbols().get(ball.id()).name()).isEqualTo("globe");
        assertThat(spring.physics().reference("end1")).isEqualTo(ball.id());
        world.add(ItemDefinition.named("ball").build());
    }

    @Test
    void aFrameKeepsABoundedNumberOfChangesAndCountsTheRest() {
        var log = new FrameLog<Integer>(2);
        for (int i = 0; i < 5; i++) {
            log.add(i);
        }
        log.fix();
        log.add(7);
        assertThat(log.entries()).containsExactly(0, 1);
        assertThat(log.lost()).isEqualTo(3);
        log.end();
        assertThat(log.entries()).containsExactly(7);
        assertThat(log.lost()).isZero();
    }

    private Edited physical(String property, Object from, Object to) {
        return new Edited(lamp.id(), Aspect.PHYSICAL, property, from, to);
    }
}
