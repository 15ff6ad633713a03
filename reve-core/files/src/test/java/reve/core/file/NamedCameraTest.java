// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import reve.core.world.OffHeapArena;
import reve.core.world.World;

import java.util.List;

/** Cameras of world files. The tests read them, write them and check their curves. */
class NamedCameraTest {
    private static final double EXACT = 1e-12;

    private static WorldDescription world(String cameras) throws WorldFileException {
        return WorldFileTest.parse(
                """
                reve: 1
                name: studio
                cameras:
                %s
                items:
                  - {name: ball, physical: {shape: sphere, radius: 1}, physics: {mass: 1}}
                  - {name: lamp, physical: {shape: box, size: [1, 1, 1]}}
                """
                        .formatted(cameras.indent(2)));
    }

    private static NamedCamera camera(String cameras) throws WorldFileException {
        return world(cameras).cameras().getFirst();
    }

    @Test
    void aCameraHasTheValuesOfTheFileAndThoseThatTheFileOmits() throws WorldFileException {
        List<NamedCamera> all =
                world(
                                """
                                side: {eye: [0, 5, 30], target: 0 500 0 cm, fov: 40 deg}
                                chase: {follow: ball, turning: true, eye: [0, 1, 3]}
                                watch: {eye: [4, 1, 0], lookAt: lamp, up: [0, 0, 1]}
                                """)
                        .cameras();
        assertThat(all).extracting(NamedCamera::name).containsExactly("side", "chase", "watch");
        CameraDescription side = all.get(0).at(7);
        assertThat(side.eye()).containsExactly(0, 5, 30);
        assertThat(side.target()).containsExactly(0, 5, 0);
        assertThat(side.up()).containsExactly(0, 1, 0);
        assertThat(side.verticalFovRadians()).isCloseTo(Math.toRadians(40), within(EXACT));
        assertThat(all.get(1).follow()).contains("ball");
        assertThat(all.get(1).turning()).isTrue();
        assertThat(all.get(1).at(0).target()).containsExactly(0, 0, 0);
        assertThat(all.get(2).lookAt()).contains("lamp");
        assertThat(all.get(2).follow()).isEmpty();
        assertThat(all.get(2).at(0).verticalFovRadians()).isEqualTo(Math.PI / 4);
    }

    @Test
    void aPathPassesThroughItsKeysAndIsSmooth() throws WorldFileException {
        NamedCamera path =
                camera(
                        """
                        path:
                          target: [0, 0, 0]
                          fov: 0.5
                          keyframes:
                            - {time: 1, eye: [0, 0, 9]}
                            - {time: 2, eye: [4, 0, 9]}
                            - {time: 4, eye: [6, 3, 9], fov: 1}
                            - {time: 5, eye: [6, 3, 9]}
                        """);
        assertThat(path.at(-3).eye()).containsExactly(0, 0, 9);
        assertThat(path.at(1).eye()).containsExactly(0, 0, 9);
        assertThat(path.at(2).eye()).containsExactly(4, 0, 9);
        assertThat(path.at(4).eye()).containsExactly(6, 3, 9);
        assertThat(path.at(4).verticalFovRadians()).isEqualTo(1);
        assertThat(path.at(99).eye()).containsExactly(6, 3, 9);
        // between rest at 0 and the slope (6 - 0) / (4 - 1) = 2 at 4: 4 s^2 (3 - 2 s) - 2 s^2 (1 -
        // s)
        for (double s : new double[] {0.25, 0.5, 0.9}) {
            double expected = 4 * s * s * (3 - 2 * s) - 2 * s * s * (1 - s);
            assertThat(path.at(1 + s).eye()[0]).isCloseTo(expected, within(EXACT));
        }
        double step = 1e-6;
        for (double key : new double[] {1, 2, 4, 5}) {
            double before = (path.at(key).eye()[0] - path.at(key - step).eye()[0]) / step;
            double after = (path.at(key + step).eye()[0] - path.at(key).eye()[0]) / step;
            assertThat(before).as("speed at %s s", key).isCloseTo(after, within(1e-4));
        }
    }

    @Test
    void aWorldThatIsSavedKeepsItsCamerasAsLongAsTheirItemsAreThere() throws WorldFileException {
        WorldDescription world =
                world(
                        """
                        chase: {follow: ball, turning: true, eye: [0, 1, 3], fov: 1}
                        watch: {lookAt: lamp, keyframes: [{time: 0, eye: [4, 1, 0]}, {time: 2.5, eye: [0, 1, 0.1]}]}
                        """);
        WorldDescription saved = WorldFileTest.parse(WorldWriter.write(world));
        assertThat(saved.cameras()).hasSize(2);
        for (int i = 0; i < 2; i++) {
            NamedCamera before = world.cameras().get(i);
            NamedCamera after = saved.cameras().get(i);
            assertThat(after.name()).isEqualTo(before.name());
            assertThat(after.follow()).isEqualTo(before.follow());
            assertThat(after.turning()).isEqualTo(before.turning());
            assertThat(after.lookAt()).isEqualTo(before.lookAt());
            for (double time : new double[] {0, 1, 2.5}) {
                assertThat(after.at(time).eye()).isEqualTo(before.at(time).eye());
                assertThat(after.at(time).up()).isEqualTo(before.at(time).up());
                assertThat(after.at(time).verticalFovRadians())
                        .isEqualTo(before.at(time).verticalFovRadians());
            }
        }
        try (var arena = new OffHeapArena()) {
            World later = world.build(arena);
            later.remove(later.find("lamp").orElseThrow().id());
            String text = WorldWriter.write(world.of(later, List.of()));
            assertThat(WorldFileTest.parse(text).cameras())
                    .extracting(NamedCamera::name)
                    .containsExactly("chase");
        }
    }
}
