// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.agent.auth.Rights;
import reve.core.file.AgentPolicy;
import reve.core.world.FrameControl;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;

import java.util.List;
import java.util.Map;
import java.util.Optional;

class EmbodimentTest {

    @Test
    void aBodyMadeForAnAgentGoesWithItWhateverItIsCalledNow() {
        World world = new World("w", WorldPrototype.standard("si-f64"), new OffHeapArena());
        var policy = new AgentPolicy(List.of(), Optional.of(ItemDefinition.named("body").build()));
        var members = new Embodiment(policy, 60);
        members.apply(world, 1, new AgentInput.Join("ann", Optional.empty(), Rights.ALL));
        world.rename(world.find("ann").orElseThrow().id(), "ghost");
        members.apply(world, 2, new AgentInput.Leave("ann", "bye"));
        assertThat(world.find("ghost")).isEmpty();
    }

    /**
     * The attached items are items of designers, items attached to them, and another agent's body.
     */
    @Test
    void whatIsAttachedToABodyStaysWhereItIsWhenTheBodyLeaves() {
        World world = new World("w", WorldPrototype.standard("si-f64"), new OffHeapArena());
        Embodiment members = membersWithBodies();
        members.apply(world, 1, join("ann"));
        members.apply(world, 1, join("bob"));
        Item hook = world.add(body("hook", 1, 2, 3));
        Item chain = world.add(body("chain", 1, 1, 3));
        Item bob = world.find("bob").orElseThrow();
        Item ann = world.find("ann").orElseThrow();
        world.add(
                ItemDefinition.named("spring")
                        .kind("spring")
                        .reference("end1", "hook")
                        .reference("end2", "bob")
                        .build());
        world.attach(chain.id(), hook.id());
        world.attach(hook.id(), ann.id());
        world.attach(bob.id(), ann.id());
        ann.physical().setLocation(5, 0, 0);
        double[] hookAt = hook.physical().location();
        double[] bobAt = bob.physical().location();

        members.apply(world, 2, new AgentInput.Leave("ann", "bye"));
        FrameControl.of(world).placeAttached();

        assertThat(world.find("ann")).isEmpty();
        assertThat(hook.parent()).isEmpty();
        assertThat(hook.physical().location()).containsExactly(hookAt).contains(6, 2, 3);
        assertThat(chain.parent()).contains(hook.id());
        assertThat(chain.physical().location()).containsExactly(6, 1, 3);
        assertThat(bob.physical().location()).containsExactly(bobAt);
        assertThat(world.find("spring")).isPresent();
        assertThat(events(world))
                .containsExactly(
                        "joined ann", "joined bob", "detached bob", "detached hook", "left ann");
        assertThat(members.apply(world, 3, new AgentInput.Leave("bob", "bye")))
                .isEqualTo(new Outcome.Done(3));
        assertThat(events(world)).contains("removed spring");
    }

    /**
     * A spring without one of its ends is removed, because a spring needs both ends and the server
     * cannot refuse that an agent leaves.
     */
    @Test
    void eachItemThatGoesWithABodyIsNamedInAnEvent() {
        World world = new World("w", WorldPrototype.standard("si-f64"), new OffHeapArena());
        Embodiment members = membersWithBodies();
        members.apply(world, 1, join("ann"));
        Item bob = world.add(body("bob", 0, 1, 0));
        world.add(
                ItemDefinition.named("rope")
                        .kind("spring")
                        .reference("end1", "ann")
                        .reference("end2", "bob")
                        .build());
        world.attach(bob.id(), world.find("ann").orElseThrow().id());

        members.apply(world, 2, new AgentInput.Leave("ann", "lost"));

        assertThat(world.items()).extracting(Item::name).containsExactly("world", "bob");
        assertThat(world.events().get(2))
                .isEqualTo(
                        new WorldEvent(
                                2,
                                "removed",
                                Map.of("agent", "ann", "body", "ann", "item", "rope")));
        assertThat(events(world))
                .containsExactly("joined ann", "detached bob", "removed rope", "left ann");
    }

    @Test
    void whatIsAttachedStaysWhenTheWorldIsRewoundToABodyWhoseAgentHasLeft() {
        World world = new World("w", WorldPrototype.standard("si-f64"), new OffHeapArena());
        Embodiment members = membersWithBodies();
        Item ann = world.add(body("ann", 0, 0, 0));
        Item hook = world.add(body("hook", 1, 2, 3));
        world.attach(hook.id(), ann.id());

        members.rewound(world, 5, Map.of("ann", ann.id()));

        assertThat(world.items()).extracting(Item::name).containsExactly("world", "hook");
        assertThat(hook.physical().location()).containsExactly(1, 2, 3);
        assertThat(events(world)).containsExactly("detached hook");
    }

    private static Embodiment membersWithBodies() {
        return new Embodiment(new AgentPolicy(List.of(), Optional.of(body("body", 0, 0, 0))), 60);
    }

    private static ItemDefinition body(String name, double x, double y, double z) {
        return ItemDefinition.named(name).at(x, y, z).physics("mass", 0).build();
    }

    private static AgentInput.Join join(String agent) {
        return new AgentInput.Join(agent, Optional.empty(), Rights.ALL);
    }

    private static List<String> events(World world) {
        return world.events().stream()
                .map(
                        event ->
                                event.type()
                                        + " "
                                        + event.fields()
                                                .getOrDefault("item", event.fields().get("agent")))
                .toList();
    }
}
