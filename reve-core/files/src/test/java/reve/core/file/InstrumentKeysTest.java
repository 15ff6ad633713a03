// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.world.Instrument;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Sensor;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.nio.charset.StandardCharsets;
import java.util.List;
import java.util.stream.Collectors;
import java.util.stream.IntStream;

/** The keys of sensors that measure numbers. */
class InstrumentKeysTest {
    private static WorldDescription parse(String rest) throws WorldFileException {
        return WorldFile.parse("w", ("reve: 1\nname: w\n" + rest).getBytes(StandardCharsets.UTF_8));
    }

    private static Sensor onlySensor(WorldDescription world) {
        return world.items().getFirst().sensors().getFirst();
    }

    @Test
    void anImuHasErrorsInItsUnitsASeedAndAnInterval() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        items:
                          - name: a
                            physics: {mass: 1}
                            sensors:
                              inertia:
                                every: 3
                                imu:
                                  specificForce: {noise: 2 cm/s^2, bias: 0 10 -20 mm/s^2}
                                  angularVelocity: {noise: 90 deg/s, bias: [0.5, 0, 0]}
                                  seed: 9007199254740991
                        """);
        Sensor sensor = onlySensor(world);
        assertThat(sensor.name()).isEqualTo("inertia");
        assertThat(sensor.every()).isEqualTo(3);
        assertThat(sensor.sensesItems()).isFalse();
        assertThat(sensor.isUnlimited()).isFalse();
        assertThat(sensor.instrument())
                .contains(
                        new Instrument.Imu(
                                new Instrument.Errors(0.02, 0, 0.01, -0.02),
                                new Instrument.Errors(Math.toRadians(90), 0.5, 0, 0),
                                Instrument.GREATEST_SEED));
        WorldDescription again = WorldFileTest.parse(WorldWriter.write(world));
        assertThat(onlySensor(again)).isEqualTo(sensor);
        assertThat(again.prototype().properties()).isEqualTo(world.prototype().properties());
    }

    /** Other worlds keep their images, because they do not have these properties. */
    @Test
    void onlyWorldsWithAnImuHaveTheColumnsOfIts() throws WorldFileException {
        List<String> columns = List.of("specificForce", "angularRate");
        for (String world :
                List.of(
                        "items: [{name: a, physics: {mass: 1}, sensors: {i: {imu: {}}}}]",
                        "prefabs: {p: {sensors: {i: {imu: {}}}}}",
                        "agents: {body: {sensors: {i: {imu: {}}}}}",
                        """
                        items:
                          - name: a
                            access:
                              make: {effects: [create: {name: b, sensors: {i: {imu: {}}}}]}
                        """)) {
            WorldPrototype prototype = parse(world).prototype();
            assertThat(columns).allMatch(name -> prototype.find("body", name).isPresent(), world);
        }
        WorldPrototype prototype =
                parse("items: [{name: a, sensors: {eye: {range: 3}}}]").prototype();
        assertThat(columns).noneMatch(name -> prototype.find("body", name).isPresent());
    }

    @Test
    void aWorldWithoutTheColumnsRefusesAnItemWithAnImu() {
        var world = new World("w", WorldPrototype.standard("si-f64"), new OffHeapArena());
        ItemDefinition item =
                ItemDefinition.named("late")
                        .sensor(
                                Sensor.measuring(
                                        "tilt",
                                        new Instrument.Imu(
                                                Instrument.Errors.NONE, Instrument.Errors.NONE, 0)))
                        .build();
        assertThatThrownBy(() -> world.add(item))
                .isInstanceOf(IllegalArgumentException.class)
                .hasMessageStartingWith(
                        "item late: sensor tilt needs the property specificForce, which this world"
                                + " does not have; give such a sensor to");
        assertThat(world.find("late")).isEmpty();
    }

    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '!',
            textBlock =
                    """
                    {imu: {specificForce: {noise: 3 kg}}}      ! noise: unit kg does not fit m/s^2
                    {imu: {angularVelocity: {bias: 1 2 3 m/s}}}! bias: unit m/s does not fit rad/s
                    {imu: {specificForce: {bias: [1, 2]}}}     ! bias: found 2 numbers, expected 3 numbers in m/s^2
                    {imu: {specificForce: {noise: -1}}}        ! noise: -1.0, expected 0 or more
                    {imu: {seed: -1}}                          ! seed: found number -1, expected at least 0
                    {imu: {sead: 1}}                           ! unknown key `sead`; did you mean `seed`?
                    {imu: true}                                ! imu: found `true`, expected a mapping
                    {imu: {}, range: 3}                        ! range: a sensor with `imu` only measures; leave it out
                    {lidar: {rays: 3, angle: 1 deg}}           ! lidar: `range` is missing
                    {lidar: {rays: 3, range: 1}}               ! angle: 0.0 deg for 3 rays, expected more than 0 and at most 360 deg
                    {lidar: {rays: 1, angle: 9 deg, range: 1}} ! deg for 1 ray, expected 0
                    {lidar: {rays: 2, angle: 361 deg, range: 1}} ! angle: 361.0 deg for 2 rays, expected more than 0 and at most 360 deg
                    {lidar: {rays: 2, angle: 3 m, range: 1}}   ! angle: unit m does not fit 1
                    {lidar: {rays: 3, angle: 1, range: 3 s}}   ! range: unit s does not fit m
                    {lidar: {rays: 3, angle: 1, range: 0}}     ! range: 0.0 m is not more than 0
                    {lidar: {rays: 65, angle: 1, rows: 64, rowAngle: 1, range: 9}} ! rays: 4160 in all rows, expected 1 to 4096
                    {contactForce: {axes: up}}                 ! axes: found text `up`, expected one of `world`, `body`
                    {contactForce: {}, touch: true}            ! touch: a sensor with `contactForce` only measures; leave it out
                    {imu: {}, camera: {size: [3, 3]}}          ! camera: a sensor with `imu` only measures; leave it out
                    """)
    void aMistakeIsReportedAtItsLine(String sensor, String message) {
        assertThatThrownBy(
                        () ->
                                parse(
                                        "items:\n  - name: a\n    physics: {mass: 1}\n"
                                                + "    sensors:\n      i: "
                                                + sensor))
                .hasMessageContaining("w:7:")
                .hasMessageContaining(message.strip());
    }

    @Test
    void aLidarIsAFanOrAGrid() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        items:
                          - name: a
                            sensors:
                              fan: {lidar: {rays: 31, angle: 90 deg, range: 500 cm}}
                              grid: {every: 2, lidar: {rays: 8, angle: 360 deg, rows: 4, rowAngle: 0.5, range: 9, noise: 2 mm, seed: 5}}
                              one: {lidar: {rays: 1, range: 1 km}}
                        """);
        List<Sensor> sensors = world.items().getFirst().sensors();
        assertThat(sensors.get(0).instrument())
                .contains(new Instrument.Lidar(31, 1, Math.toRadians(90), 0, 5, 0, 0));
        assertThat(sensors.get(1).instrument())
                .contains(new Instrument.Lidar(8, 4, Sensor.ALL_ROUND, 0.5, 9, 0.002, 5));
        assertThat(sensors.get(2).instrument())
                .contains(new Instrument.Lidar(1, 1, 0, 0, 1000, 0, 0));
        assertThat(WorldFileTest.parse(WorldWriter.write(world)).items().getFirst().sensors())
                .isEqualTo(sensors);
        assertThat(world.prototype().properties())
                .doesNotContainAnyElementsOf(world.prototype().propertiesOnDemand());
    }

    @Test
    void aSensorOfContactForcesHasTheAxesOfTheWorldOrOfTheBody() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        items:
                          - name: a
                            physics: {mass: 1}
                            sensors: {one: {contactForce: {}}, other: {contactForce: {axes: body}}}
                        """);
        List<Sensor> sensors = world.items().getFirst().sensors();
        assertThat(sensors)
                .extracting(sensor -> sensor.instrument().orElseThrow())
                .containsExactly(
                        new Instrument.ContactForce(false), new Instrument.ContactForce(true));
        for (String property : List.of("contactForce", "reactionForce")) {
            assertThat(world.prototype().find("body", property)).as(property).isPresent();
        }
        assertThat(world.prototype().find("body", "specificForce")).isEmpty();
        assertThat(WorldFileTest.parse(WorldWriter.write(world)).items().getFirst().sensors())
                .isEqualTo(sensors);
    }

    @Test
    void theRaysOfAllBodiesOfAgentsAreLimited() throws WorldFileException {
        String lidar =
                "sensors: {scan: {lidar: {rays: 4096, angle: 90 deg, range: 9 m}, every: %d}}";
        String body = "agents: {most: 17, body: {" + lidar + "}}";
        parse(body.formatted(2));
        assertThatThrownBy(() -> parse(body.formatted(1)))
                .hasMessage(
                        "w:3:1: agents: the lidars of all bodies cast 69632 rays in a frame,"
                                + " expected at most 65536; use fewer `rays`, a greater `every`, or"
                                + " fewer bodies (`most`, `places`)");
        parse(body.replace("most: 17", "most: 17, places: [[0, 0, 0]]").formatted(1));
        String items = "items: [{name: 'a{i}', repeat: 17, " + lidar.formatted(1) + "}]\n";
        parse(items);
        assertThatThrownBy(
                        () ->
                                parse(
                                        items
                                                + "agents: {bodies: ["
                                                + IntStream.range(0, 17)
                                                        .mapToObj(i -> "a" + i)
                                                        .collect(Collectors.joining(", "))
                                                + "]}"))
                .hasMessageContaining("cast 69632 rays in a frame");
    }

    @Test
    void aDesignersPropertyCannotHaveTheNameOfAMeasurement() {
        assertThatThrownBy(
                        () ->
                                parse(
                                        """
                                        properties: [{name: specificForce, kind: body, unit: N}]
                                        items: [{name: a, physics: {mass: 1}, sensors: {i: {imu: {}}}}]
                                        """))
                .hasMessage(
                        "w:3:21: specificForce: a sensor of this world measures the property of"
                                + " this name; choose another name");
    }
}
