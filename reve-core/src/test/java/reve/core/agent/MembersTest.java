package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import java.util.List;
import java.util.Optional;
import org.junit.jupiter.api.Test;
import reve.core.file.AgentPolicy;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

class MembersTest {

    @Test
    void aBodyMadeForAnAgentGoesWithItWhateverItIsCalledNow() {
        World world = new World("w", WorldPrototype.standard("si-f64"), new OffHeapArena());
        var policy = new AgentPolicy(List.of(), Optional.of(ItemDefinition.named("body").build()));
        var members = new Members(policy, 60);
        members.apply(world, 1, new AgentInput.Join("ann", Optional.empty(), Rights.ALL));
        world.rename(world.find("ann").orElseThrow().id(), "ghost");
        members.apply(world, 2, new AgentInput.Leave("ann", "bye"));
        assertThat(world.find("ghost")).isEmpty();
    }
}
