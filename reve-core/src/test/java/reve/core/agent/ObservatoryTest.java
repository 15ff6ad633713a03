package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import java.nio.charset.StandardCharsets;
import java.util.List;
import org.junit.jupiter.api.Test;
import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Terms;
import reve.core.derive.BoundingBoxes;
import reve.core.unit.Unit;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Parameter;
import reve.core.world.Shape;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.core.world.WorldPrototype;
import tools.jackson.databind.JsonNode;

class ObservatoryTest {
    private static JsonNode perceived(boolean relations) {
        try (var arena = new OffHeapArena()) {
            World world = new World("test", WorldPrototype.standard("si-f64"), arena);
            var take = new DeclaredAction("take", "",
                    List.of(Parameter.number("speed", 1, Unit.parse("m/s"), "").within(0, 2),
                            Parameter.item("to", "")),
                    new Terms(List.of("grip"), List.of()),
                    List.of(new Effect.Raise("taken", "take")));
            world.add(ItemDefinition.named("table").shape(Shape.box(1, 1, 1)).build());
            world.add(ItemDefinition.named("cup").shape(Shape.box(0.1, 0.1, 0.1)).at(0, 0.55, 0)
                    .symbol("tags", List.of("red", 2, true)).action(take).build());
            world.add(ItemDefinition.named("hand").capability("grip").capability("push").build());
            new BoundingBoxes().update(world);
            var ring = new SnapshotRing(world, 2);
            ring.publish(1, 0.1);
            try (var snapshot = ring.acquireLatest().orElseThrow()) {
                var observatory = new Observatory();
                assertThat(observatory.read(snapshot)).isTrue();
                View view = relations ? observatory.withRelations(observatory.everything(), snapshot).orElseThrow()
                        : observatory.everything();
                var out = new Bytes();
                new Telling().write(out, Encoding.JSON, ClientMessage.NO_ID, view, null);
                return Json.MAPPER.readTree(new String(out.toArray(), StandardCharsets.UTF_8)).get("items");
            }
        }
    }

    @Test
    void actionsTellTheirRangesAndNeedsAndBodiesWhatTheyCanDo() {
        JsonNode items = perceived(false);

        JsonNode cup = items.get(1);
        assertThat(cup.get("actions").get("take")).hasToString("{\"speed\":{\"type\":\"number\","
                + "\"components\":1,\"unit\":\"m/s\",\"min\":0.0,\"max\":2.0},"
                + "\"to\":{\"type\":\"item\"}}");
        assertThat(cup.get("needs")).hasToString("{\"take\":[\"grip\"]}");
        assertThat(cup.has("capabilities")).isFalse();
        assertThat(cup.get("symbols").get("tags")).hasToString("[\"red\",2.0,true]");
        assertThat(items.get(2).get("capabilities")).hasToString("[\"grip\",\"push\"]");
        assertThat(items.get(2).has("needs")).isFalse();
    }

    @Test
    void relationsAreToldToWhoAsksForThem() {
        assertThat(perceived(false).get(1).get("symbols").has("on")).isFalse();

        JsonNode items = perceived(true);
        assertThat(items.get(1).get("symbols").get("on")).hasToString("[\"table\"]");
        assertThat(items.get(0).get("symbols").get("on")).hasToString("[]");
        assertThat(items.get(0).get("symbols").get("near")).hasToString("[\"cup\"]");
        assertThat(items.get(1).get("symbols").get("name").stringValue()).isEqualTo("cup");
        assertThat(items.get(2).get("symbols").has("on")).isFalse();
    }
}
