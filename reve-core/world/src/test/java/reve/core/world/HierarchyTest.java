// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import java.util.ArrayList;
import java.util.Collections;
import java.util.List;
import java.util.Random;

class HierarchyTest {

    private static final double HALF = Math.sqrt(0.5);

    private final World world =
            new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena());

    private Item body(String name, double x, double y, double z) {
        return world.add(ItemDefinition.named(name).at(x, y, z).build());
    }

    private static void assertAt(Item item, double x, double y, double z) {
        double[] at = item.physical().location();
        assertThat(at[0]).as(item + " x").isCloseTo(x, within(1e-12));
        assertThat(at[1]).as(item + " y").isCloseTo(y, within(1e-12));
        assertThat(at[2]).as(item + " z").isCloseTo(z, within(1e-12));
    }

    private double[] positionColumn(Item item) {
        Table bodies = world.table("body");
        int row = bodies.rowOf(item.id());
        return new double[] {
            bodies.column("position").getDouble(row, 0),
            bodies.column("position").getDouble(row, 1),
            bodies.column("position").getDouble(row, 2)
        };
    }

    @Test
    void aWheelMovesAndTurnsWithItsCart() {
        Item cart = body("cart", 10, 0, 0);
        Item wheel = body("wheel", 12, 0, 0);
        world.attach(wheel.id(), cart.id());
        assertThat(wheel.parent()).contains(cart.id());
        assertThat(cart.children()).containsExactly(wheel.id());
        assertAt(wheel, 12, 0, 0);

        cart.physical().setLocation(0, 5, 0);
        assertAt(wheel, 2, 5, 0);
        cart.physical().setOrientation(0, HALF, 0, HALF); // a quarter turn about y: x to -z
        FrameControl.of(world).placeAttached();
        assertThat(positionColumn(wheel)).containsExactly(wheel.physical().location());
        assertAt(wheel, 0, 5, -2);
        assertThat(wheel.physical().orientation()[1]).isCloseTo(HALF, within(1e-15));
    }

    @Test
    void aChildThatIsMovedKeepsItsNewPlaceInItsParentsFrame() {
        Item cart = body("cart", 0, 0, 0);
        Item wheel = body("wheel", 1, 0, 0);
        world.attach(wheel.id(), cart.id());
        cart.physical().setOrientation(0, HALF, 0, HALF);
        wheel.physical().setLocation(3, 0, 0);
        assertAt(wheel, 3, 0, 0);
        cart.physical().setOrientation(0, 0, 0, 1);
        assertAt(wheel, 0, 0, 3);
    }

    @Test
    void attachingToALongChainCostsStepsForEachOfItsLevels() {
        Item last = body("item-0", 0, 0, 0);
        for (int i = 1; i <= 1000; i++) {
            Item next = body("item-" + i, i, 0, 0);
            world.attach(next.id(), last.id());
            last = next;
        }
        long before = world.activity().steps();
        world.attach(body("one more", 0, 1, 0).id(), last.id());
        assertThat(world.activity().steps() - before).isBetween(1000L, 4000L);
    }

    @Test
    void whatIsDetachedStaysWhereItIs() {
        Item cart = body("cart", 0, 0, 0);
        Item wheel = body("wheel", 1, 0, 0);
        world.attach(wheel.id(), cart.id());
        cart.physical().setLocation(0, 7, 0);
        world.detach(wheel.id());
        cart.physical().setLocation(100, 0, 0);
        FrameControl.of(world).placeAttached();
        assertAt(wheel, 1, 7, 0);
        assertThat(wheel.parent()).isEmpty();
        assertThat(cart.children()).isEmpty();
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.detach(wheel.id()))
                .withMessageContaining("item wheel (body #3) is not attached to anything");
    }

    @Test
    void definitionsPlaceAChildInItsParentsFrameInAnyOrder() {
        List<ItemDefinition> chain = new ArrayList<>();
        chain.add(ItemDefinition.named("link0").at(1, 2, 3).orientation(0, HALF, 0, HALF).build());
        for (int i = 1; i < 50; i++) {
            chain.add(
                    ItemDefinition.named("link" + i).parent("link" + (i - 1)).at(1, 0, 0).build());
        }
        Collections.shuffle(chain, new Random(7));
        world.addAll(chain);
        Item last = world.find("link49").orElseThrow();
        assertThat(positionColumn(last)).containsExactly(last.physical().location());
        assertAt(last, 1, 2, 3 - 49);
        world.find("link0").orElseThrow().physical().setLocation(0, 0, 0);
        FrameControl.of(world).placeAttached();
        assertAt(last, 0, 0, -49);
        assertThat(positionColumn(last)).containsExactly(last.physical().location());
    }

    @Test
    void aChainOfAnyDepthNeedsNoStack() {
        List<ItemDefinition> chain = new ArrayList<>();
        chain.add(ItemDefinition.named("link0").build());
        for (int i = 1; i < 20_000; i++) {
            chain.add(
                    ItemDefinition.named("link" + i).parent("link" + (i - 1)).at(1, 0, 0).build());
        }
        world.addAll(chain);
        world.find("link0").orElseThrow().physical().setLocation(0, 1, 0);
        FrameControl.of(world).placeAttached();
        assertThat(positionColumn(world.find("link19999").orElseThrow()))
                .containsExactly(19_999, 1, 0);
    }

    @Test
    void nothingMovesWithItself() {
        Item a = body("a", 0, 0, 0);
        Item b = body("b", 0, 0, 0);
        Item c = body("c", 0, 0, 0);
        world.attach(b.id(), a.id());
        world.attach(c.id(), b.id());
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.attach(a.id(), c.id()))
                .withMessage(
                        "item a (body #2) cannot be attached to item c (body #4): c already "
                                + "moves with a");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.attach(a.id(), a.id()))
                .withMessageContaining("it is the same item");
        var circle =
                List.of(
                        ItemDefinition.named("x").parent("y").build(),
                        ItemDefinition.named("y").parent("x").build());
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.addAll(circle))
                .withMessage("item x cannot be attached to itself, as by x to y");
        assertThat(world.find("x")).isEmpty();
    }

    @Test
    void lawsDoNotMoveWhatMovesWithSomethingElse() {
        Item cart = world.add(ItemDefinition.named("cart").physics("mass", 5).build());
        Item ball = world.add(ItemDefinition.named("ball").physics("mass", 2).build());
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.attach(ball.id(), cart.id()))
                .withMessage(
                        "item ball (body #3) cannot be attached to item cart (body #2): mass is 2.0"
                                + " kg, but laws cannot move what moves with another item: give it mass"
                                + " 0, or hold it with a spring");
        ball.physics().set("mass", 0);
        world.attach(ball.id(), cart.id());
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.physics().set("mass", 1))
                .withMessageContaining("item ball (body #3) is attached to cart: mass is 1.0 kg");
        assertThatIllegalArgumentException()
                .isThrownBy(
                        () ->
                                world.add(
                                        ItemDefinition.named("wheel")
                                                .parent("cart")
                                                .physics("mass", 1)
                                                .build()))
                .withMessageContaining("item wheel cannot be attached to cart: mass is 1.0 kg");
        assertThat(world.find("wheel")).isEmpty();
    }

    @Test
    void onlyBodiesAreAttachedAndOnlyToWhatIsThere() {
        body("a", 0, 0, 0);
        Item constants = world.find("world").orElseThrow();
        Item a = world.find("a").orElseThrow();
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.attach(a.id(), constants.id()))
                .withMessageContaining("world is of kind world, which has no place");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.add(ItemDefinition.named("b").parent("nobody").build()))
                .withMessage("item b cannot be attached to nobody: it does not exist");
        assertThatIllegalArgumentException()
                .isThrownBy(
                        () ->
                                world.add(
                                        ItemDefinition.named("s")
                                                .kind("spring")
                                                .parent("a")
                                                .build()))
                .withMessageContaining("s is of kind spring");
    }

    @Test
    void aParentStaysUntilItsChildrenAreGone() {
        Item cart = body("cart", 0, 0, 0);
        Item wheel = body("wheel", 1, 0, 0);
        Item hub = body("hub", 1, 0, 0);
        world.attach(wheel.id(), cart.id());
        world.attach(hub.id(), wheel.id());
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.remove(cart.id()))
                .withMessageContaining("item wheel (body #3) refers to it or is attached to it");
        world.removeCascade(cart.id());
        assertThat(world.items()).extracting(Item::name).containsExactly("world");
        FrameControl.of(world).placeAttached();
    }

    @Test
    void theHierarchyIsFixedWhereTheStructureIs() {
        Item cart = body("cart", 0, 0, 0);
        Item wheel = body("wheel", 1, 0, 0);
        FrameControl.of(world).lock("PHYSICS");
        assertThatIllegalStateException()
                .isThrownBy(() -> world.attach(wheel.id(), cart.id()))
                .withMessageContaining("PHYSICS");
        assertThatIllegalStateException().isThrownBy(() -> world.detach(wheel.id()));
        assertThatIllegalStateException().isThrownBy(() -> world.rename(wheel.id(), "tyre"));
    }

    @Test
    void whatLawsSeeOfAnAttachedBodyIsMarkedAsEdited() {
        Item cart = body("cart", 0, 0, 0);
        Item lamp = body("lamp", 1, 0, 0);
        world.attach(lamp.id(), cart.id());
        Column positions = world.table("body").column("position");
        long before = positions.version();
        FrameControl.of(world).placeAttached();
        assertThat(positions.version()).isEqualTo(before);
        lamp.physics().set("mass", 0);
        FrameControl.of(world).placeAttached();
        assertThat(positions.version()).isGreaterThan(before);
    }
}
