// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;

import reve.core.world.Colour;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.Material;
import reve.core.world.Mesh;
import reve.core.world.OffHeapArena;
import reve.core.world.Shape;
import reve.core.world.SnapshotRing;
import reve.core.world.Texture;
import reve.core.world.World;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.util.Optional;

class SceneTest {
    private final OffHeapArena arena = new OffHeapArena();
    private final World world = new World("w", WorldPrototype.standard("si-f64"), arena);
    private final SnapshotRing snapshots = new SnapshotRing(world, 3);
    private final Scene scene = new Scene();
    private long frame;

    @AfterEach
    void close() {
        arena.close();
    }

    private static Mesh triangle(float size) {
        return new Mesh(new float[] {0, 0, 0, size, 0, 0, 0, size, 0}, new int[] {0, 1, 2});
    }

    private void read() {
        snapshots.publish(++frame, frame / 60.0);
        scene.forget();
        try (WorldSnapshot snapshot = snapshots.acquireLatest().orElseThrow()) {
            assertThat(scene.read(snapshot, 0)).isTrue();
        }
    }

    /**
     * Otherwise a world whose shapes change again and again would fill the memory of its server.
     */
    @Test
    void meshesThatNoItemHasAreDropped() {
        Mesh first = triangle(1);
        Mesh shared = triangle(2);
        Item a = world.add(ItemDefinition.named("a").shape(first).build());
        Item b = world.add(ItemDefinition.named("b").shape(shared).build());
        Item c = world.add(ItemDefinition.named("c").shape(shared).build());
        read();
        assertThat(scene.assets()).hasSize(2);

        a.physical().setShape(triangle(3));
        world.remove(b.id());
        read();
        assertThat(scene.assetId(first)).isZero();
        assertThat(scene.assetId(shared)).isPositive();
        assertThat(scene.assets()).hasSize(2).contains(scene.assetId(shared));

        world.remove(c.id());
        read();
        assertThat(scene.assetId(shared)).isZero();
        for (int change = 0; change < 20; change++) {
            a.physical().setShape(triangle(4 + change));
            read();
        }
        assertThat(scene.assets()).singleElement().satisfies(id -> assertThat(id).isEqualTo(23));
    }

    /** The size is a column of its own, so a page need not read the item again. */
    @Test
    void anotherSizeChangesNoStructure() {
        Item a = world.add(ItemDefinition.named("a").shape(Shape.sphere(1)).build());
        read();
        int before = scene.version();
        a.physical().setShape(Shape.sphere(2));
        read();
        assertThat(scene.version()).isGreaterThan(before);
        assertThat(scene.hasNewStructure(before)).isFalse();
        a.physical().setShape(Shape.box(4, 4, 4));
        read();
        assertThat(scene.hasNewStructure(before)).isTrue();
    }

    @Test
    void aTextureStaysWhileAnItemHasIt() {
        var texture = new Texture(1, 1, new byte[4], Optional.empty());
        Material wood = new Material(Colour.WHITE, 0.5, 0, Optional.of(texture));
        Item a = world.add(ItemDefinition.named("a").shape(triangle(1)).material(wood).build());
        Item b = world.add(ItemDefinition.named("b").shape(triangle(2)).material(wood).build());
        read();
        world.remove(a.id());
        read();
        assertThat(scene.assetId(texture)).isPositive();
        world.remove(b.id());
        read();
        assertThat(scene.assets()).isEmpty();
        assertThat(scene.assetId(texture)).isZero();
    }

    @Test
    void anotherLookOfASpringChangesTheStructure() {
        world.add(ItemDefinition.named("a").physics("mass", 1).build());
        world.add(ItemDefinition.named("b").physics("mass", 1).build());
        Item spring =
                world.add(
                        ItemDefinition.named("s")
                                .kind("spring")
                                .reference("end1", "a")
                                .reference("end2", "b")
                                .build());
        read();
        int before = scene.version();
        read();
        assertThat(scene.hasNewStructure(before)).isFalse();
        spring.physical().setWidth(0.1);
        read();
        assertThat(scene.hasNewStructure(before)).isTrue();
    }
}
