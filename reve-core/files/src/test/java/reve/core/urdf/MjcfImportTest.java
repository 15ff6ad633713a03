// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.Seed;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.mesh.MassProperties;
import reve.core.world.ItemDefinition;
import reve.core.world.Mesh;
import reve.core.world.Pose;
import reve.core.world.Shape;

import java.awt.image.BufferedImage;
import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Map;
import java.util.Random;
import java.util.stream.Collectors;

import javax.imageio.ImageIO;

/** Files of MJCF as worlds: joints, layers, actuators and scenery, and files that are wrong. */
class MjcfImportTest {
    private static final String ROBOT =
            """
            <mujoco model="robot">
              <option timestep="0.0005" gravity="1 2 -3" solver="CG"/>
              <default>
                <geom contype="1" conaffinity="0" friction="0.8" density="1000"/>
                <default class="leg"><joint axis="0 1 0" range="-60 60" damping="1"/></default>
              </default>
              <asset><material name="red" rgba="1 0 0 1"/></asset>
              <worldbody>
                <geom name="ground" type="plane" size="0 5 1" conaffinity="1" friction="0.9"/>
                <geom name="sign" size="0.1" pos="0 0 3" contype="0"/>
                <body name="trunk" pos="0 0 1">
                  <freejoint/>
                  <geom type="capsule" size="0.1 0.2" material="red"/>
                  <geom type="box" size="0.1 0.1 0.1" contype="0" mass="0" rgba="0 1 0 0.5"/>
                  <body name="leg" pos="0 0.2 0" childclass="leg">
                    <joint name="hip" pos="0 0 0.1" frictionloss="0.3" ref="30"/>
                    <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.05"/>
                    <body name="slide" pos="0 0 -0.5">
                      <joint name="rail" type="slide" range="-0.1 0.2"/>
                      <geom size="0.05"/>
                    </body>
                  </body>
                </body>
              </worldbody>
              <actuator>
                <motor name="push" joint="hip" gear="-20" ctrlrange="-1 0.5"/>
                <position joint="rail" kp="100" kv="20" ctrlrange="0 0.1" forcerange="-7 7"/>
                <velocity joint="rail" gear="2" ctrlrange="-1 1"/>
                <velocity name="second" joint="rail"/>
                <muscle joint="hip"/>
              </actuator>
              <sensor><gyro/><gyro/></sensor>
            </mujoco>
            """;

    @TempDir private Path folder;

    private RobotImport imported(String robot, RobotImport.Base base) throws Exception {
        Path file = folder.resolve("robot.xml");
        Files.writeString(file, robot);
        return RobotImport.read(file, new RobotImport.Options(base, true, false, false, Map.of()));
    }

    private RobotImport imported(String robot) throws Exception {
        return imported(robot, RobotImport.Base.AUTOMATIC);
    }

    private WorldDescription world(RobotImport robot) throws Exception {
        Path out = folder.resolve("out");
        robot.write(out);
        return WorldFile.loadFolder(out);
    }

    private Map<String, ItemDefinition> items(RobotImport robot) throws Exception {
        return world(robot).items().stream()
                .collect(Collectors.toMap(ItemDefinition::name, item -> item));
    }

    @Test
    void aRobotHasBodiesShapesAndJoints() throws Exception {
        RobotImport robot = imported(ROBOT);
        assertThat(robot.bodies()).isEqualTo(4);
        assertThat(robot.joints()).isEqualTo(2);
        Map<String, ItemDefinition> items = items(robot);
        MassProperties capsule = MassProperties.of(Shape.capsule(0.1, 0.6), 1000);
        ItemDefinition trunk = items.get("trunk");
        assertThat(trunk.location()).containsExactly(0, 1, 0);
        assertThat(trunk.physics("mass").orElseThrow())
                .containsExactly(new double[] {capsule.mass()}, within(1e-9));
        double[] moments = capsule.moments();
        assertThat(trunk.physics("inertia").orElseThrow())
                .containsExactly(new double[] {moments[0], moments[2], moments[1]}, within(1e-9));
        assertThat(items.get("trunk shape").colour()).hasToString("#ff0000ff");
        assertThat(items.get("trunk look").colour()).hasToString("#00ff0080");
        assertThat(items.get("trunk look").hasPhysics()).isFalse();
        // The scenery collides, but the sign in the air does not.
        assertThat(items.get("ground").shape()).isEqualTo(Shape.plane(200, 10));
        assertThat(items.get("ground").hasPhysics()).isFalse();
        assertThat(items.get("world look").hasPhysics()).isFalse();
        assertThat(items.get("world look").parent()).isPresent();

        ItemDefinition hip = items.get("hip");
        assertThat(hip.references().get("joined")).containsExactly("trunk", "leg");
        assertThat(hip.physics("anchor").orElseThrow())
                .containsExactly(new double[] {0, 0.2, 0.1}, within(1e-12));
        double degree = Math.PI / 180;
        assertThat(hip.physics("angleLimits").orElseThrow())
                .containsExactly(new double[] {-90 * degree, 30 * degree}, within(1e-12));
        assertThat(hip.physics("angleFriction").orElseThrow()).containsExactly(0.3);
        assertThat(hip.physics("angleDamping").orElseThrow()).containsExactly(1);
        assertThat(hip.physics("motorTorque")).isEmpty();
        assertThat(items.get("rail").physics("travelDamping").orElseThrow()).containsExactly(1);
        assertThat(items.get("rail").physics("travelLimits").orElseThrow())
                .containsExactly(-0.1, 0.2);
        assertThat(robot.notes())
                .contains(
                        "joint hip: its angle or travel is 0 at the start, not " + 30 * degree,
                        "not imported: <muscle> of the actuators",
                        "not imported: <sensor> <gyro> (2 times)",
                        "not imported: solver of <option>",
                        "actuator second: the joint rail has the action drive of another actuator");
    }

    @Test
    void springsAndRotorsOfJointsAreThoseOfTheFile() throws Exception {
        RobotImport robot =
                imported(
                        """
                        <mujoco><worldbody><body name='a'>
                        <joint name='turn' stiffness='3' springref='90' ref='30' armature='0.2'/>
                        <geom size='1'/>
                        <body name='b'><joint name='slip' type='slide' stiffness='4' springref='0.5'
                        armature='2'/><geom size='1'/>
                        <body name='c'><joint name='ball' type='ball' damping='5' stiffness='1'
                        armature='1' frictionloss='1' springref='9'/><geom size='1'/></body></body>
                        </body><body name='d'><joint type='free' damping='1'/><geom size='1'/></body>
                        </worldbody></mujoco>
                        """);
        Map<String, ItemDefinition> items = items(robot);
        ItemDefinition turn = items.get("turn");
        assertThat(turn.physics("angleStiffness").orElseThrow()).containsExactly(3);
        assertThat(turn.physics("restAngle").orElseThrow())
                .containsExactly(new double[] {Math.PI / 3}, within(1e-12));
        assertThat(turn.physics("rotorInertia").orElseThrow()).containsExactly(0.2);
        ItemDefinition slip = items.get("slip");
        assertThat(slip.physics("travelStiffness").orElseThrow()).containsExactly(4);
        assertThat(slip.physics("restTravel").orElseThrow()).containsExactly(0.5);
        assertThat(slip.physics("rotorMass").orElseThrow()).containsExactly(2);
        assertThat(items.get("ball").physics("angleDamping").orElseThrow()).containsExactly(5);
        assertThat(robot.notes())
                .contains(
                        "not imported: stiffness of joints of type ball",
                        "not imported: armature of joints of type ball",
                        "not imported: frictionloss of joints of type ball",
                        "not imported: damping of joints of type free");
    }

    /**
     * The types and affinities of the parts match those of the floor, and not those of each other.
     */
    @Test
    void typesAndAffinitiesBecomeLayers() throws Exception {
        Map<String, ItemDefinition> items = items(imported(ROBOT));
        for (String body : new String[] {"trunk shape", "leg shape", "slide shape"}) {
            assertThat(items.get(body).physics("touchLayer").orElseThrow()).containsExactly(1);
            assertThat(items.get(body).physics("passesLayers").orElseThrow()).containsExactly(2);
            assertThat(items.get(body).physics("friction").orElseThrow()).containsExactly(0.8);
        }
        String usual = ROBOT.replace(" conaffinity=\"0\"", "");
        Map<String, ItemDefinition> others = items(imported(usual));
        assertThat(others.get("leg shape").physics("touchLayer")).isEmpty();
        assertThat(others.get("leg shape").physics("passesLayers")).isEmpty();
    }

    /** The file states half axes, and the ends of a spheroid. */
    @Test
    void ellipsoidsHaveTheAxesAndTheMassOfTheFile() throws Exception {
        RobotImport robot =
                imported(
                        """
                        <mujoco><worldbody>
                        <geom name='hill' type='ellipsoid' size='3 2 1' pos='0 0 -1'/>
                        <body name='egg' pos='0 0 2'><freejoint/>
                          <geom type='ellipsoid' size='0.1 0.2 0.3' density='500'/></body>
                        <body name='bean'><freejoint/>
                          <geom type='ellipsoid' fromto='0 0 0 0 0 0.8' size='0.1' mass='2'/></body>
                        </worldbody></mujoco>
                        """);
        assertThat(robot.notes()).isEmpty();
        Map<String, ItemDefinition> items = items(robot);
        assertThat(items.get("egg shape").shape()).isEqualTo(Shape.ellipsoid(0.2, 0.4, 0.6));
        assertThat(items.get("egg shape").physics("partOfBody").orElseThrow()).containsExactly(1);
        MassProperties egg = MassProperties.of(Shape.ellipsoid(0.2, 0.4, 0.6), 500);
        assertThat(items.get("egg").physics("mass").orElseThrow())
                .containsExactly(new double[] {egg.mass()}, within(1e-9));
        assertThat(items.get("egg").physics("inertia").orElseThrow())
                .containsExactly(egg.moments(), within(1e-9));
        assertThat(items.get("bean shape").shape()).isEqualTo(Shape.ellipsoid(0.2, 0.2, 0.8));
        assertThat(items.get("bean").physics("mass").orElseThrow())
                .containsExactly(new double[] {2}, within(1e-12));
        assertThat(items.get("hill").shape()).isEqualTo(Shape.ellipsoid(6, 4, 2));
        assertThat(items.get("hill").hasPhysics()).isFalse();
    }

    /**
     * The lowest height becomes 0, and the highest one the third number of the size. The first row
     * is at the edge +Y of the file, which is -Z of the world.
     */
    @Test
    void heightFieldsBecomeTerrains() throws Exception {
        var image = new BufferedImage(2, 2, BufferedImage.TYPE_BYTE_GRAY);
        int[] grey = {51, 51, 102, 153};
        image.getRaster().setSamples(0, 0, 2, 2, 0, grey);
        ImageIO.write(image, "png", folder.resolve("hill.png").toFile());
        RobotImport robot =
                imported(
                        """
                        <mujoco><asset>
                          <hfield name='steps' nrow='2' ncol='3' size='3 2 0.5 0.1'
                            elevation='10 10 20 10 15 10'/>
                          <hfield file='hill.png' size='1 1 4 0.1'/>
                        </asset><worldbody>
                        <geom name='ground' type='hfield' hfield='steps' pos='0 0 1'/>
                        <geom name='hill' type='hfield' hfield='hill' pos='9 0 0'/>
                        <body name='ball' pos='0 0 5'><freejoint/><geom size='0.1'/></body>
                        </worldbody></mujoco>
                        """);
        assertThat(robot.notes()).isEmpty();
        assertThat(robot.files()).containsKeys("meshes/steps.txt", "meshes/hill.txt");
        Map<String, ItemDefinition> items = items(robot);
        ItemDefinition ground = items.get("ground");
        assertThat(ground.hasPhysics()).isFalse();
        assertThat(corners(ground))
                .containsExactly(
                        new double[] {
                            -3, 1, -2, 0, 1, -2, 3, 1.5, -2, -3, 1, 2, 0, 1.25, 2, 3, 1, 2
                        },
                        within(1e-6));
        assertThat(corners(items.get("hill")))
                .containsExactly(
                        new double[] {8, 0, -1, 10, 0, -1, 8, 2, 1, 10, 4, 1}, within(1e-6));
    }

    /** Returns the vertices of a terrain in the axes of the world. */
    private static double[] corners(ItemDefinition terrain) {
        Mesh mesh = (Mesh) terrain.shape();
        Pose pose = Pose.of(terrain.location(), terrain.orientation());
        double[] corners = new double[mesh.vertices().remaining()];
        for (int i = 0; i < corners.length; i += 3) {
            Pose own =
                    new Pose(
                            mesh.vertices().get(i),
                            mesh.vertices().get(i + 1),
                            mesh.vertices().get(i + 2),
                            0,
                            0,
                            0,
                            1);
            System.arraycopy(own.within(pose).location(), 0, corners, i, 3);
        }
        return corners;
    }

    /** The number of dimensions of a contact determines which values of the friction count. */
    @ParameterizedTest
    @CsvSource({"1, 0, 0, 0", "3, 0.7, 0, 0", "4, 0.7, 0.02, 0", "6, 0.7, 0.02, 0.003"})
    void frictionAgainstSpinAndRollingIsThatOfTheFile(
            int dimensions, double sliding, double spinning, double rolling) throws Exception {
        String geom = "condim='%d' friction='0.7 0.02 0.003'".formatted(dimensions);
        RobotImport robot =
                imported(
                        """
                        <mujoco><worldbody><geom name='floor' type='plane' size='1 1 1' %s/>
                        <body name='a'><freejoint/><geom size='1' %s/></body>
                        <body name='b'><freejoint/><geom size='1' condim='6'/></body>
                        </worldbody></mujoco>
                        """
                                .formatted(geom, geom));
        Map<String, ItemDefinition> items = items(robot);
        assertThat(items.get("a shape").physics("friction").orElseThrow()).containsExactly(sliding);
        assertThat(items.get("a shape").physics("spinFriction").orElse(new double[1]))
                .containsExactly(spinning);
        assertThat(items.get("a shape").physics("rollingFriction").orElse(new double[1]))
                .containsExactly(rolling);
        assertThat(items.get("b shape").physics("spinFriction").orElseThrow())
                .containsExactly(0.005);
        assertThat(items.get("b shape").physics("rollingFriction").orElseThrow())
                .containsExactly(0.0001);
        Map<String, Double> parameters = world(robot).laws().getLast().parameters();
        assertThat(parameters.getOrDefault("friction", 0.0)).isEqualTo(sliding);
        assertThat(parameters.getOrDefault("spinFriction", 0.0)).isEqualTo(spinning);
        assertThat(parameters.getOrDefault("rollingFriction", 0.0)).isEqualTo(rolling);
        assertThat(robot.notes()).isEmpty();
    }

    @Test
    void actuatorsBecomeActionsInTheUnitsOfTheJoint() throws Exception {
        RobotImport robot = imported(ROBOT);
        String text = robot.files().get("robot.yaml").replaceAll("\\s+", " ");
        assertThat(text)
                .contains(
                        "push: doc: Exerts a torque on the joint until the next act. Actuator push."
                                + " parameters: torque: {unit: N*m, min: -10, max: 20}",
                        "travel: {unit: m, min: 0, max: 0.1} force: {unit: N, min: 0, max: 7}",
                        "{set: physics.driveTravel, to: $travel}",
                        "{set: physics.driveStiffness, to: 100}",
                        "{set: physics.driveDamping, to: 20}",
                        "{set: physics.driveDamping, to: 4}",
                        "speed: {unit: m/s, min: -0.5, max: 0.5} force: {unit: N, min: 0}");
        ItemDefinition rail = items(robot).get("rail");
        assertThat(rail.actions()).hasSize(2);
        assertThat(rail.physics("driveStiffness").orElseThrow()).containsExactly(100);
        assertThat(rail.physics("driveDamping").orElseThrow()).containsExactly(20);
        assertThat(rail.physics("driveForce").orElseThrow()).containsExactly(7);
        String geared = ROBOT.replace("kp=\"100\"", "kp=\"100\" gear=\"2\"");
        ItemDefinition two = items(imported(geared)).get("rail");
        assertThat(two.physics("driveStiffness").orElseThrow()).containsExactly(400);
        assertThat(two.physics("driveForce").orElseThrow()).containsExactly(14);
    }

    /** The torque of a velocity actuator at the speed w is gear kv (control - gear w). */
    @Test
    void aVelocityActuatorIsAMotorWithDamping() throws Exception {
        String robot =
                """
                <mujoco><worldbody><body name='a'><joint name='hinge'/><geom size='1'/>
                <body name='b'><joint name='slip' type='slide'/><geom size='1'/></body></body>
                </worldbody><actuator>
                <velocity joint='hinge' kv='3' gear='2' ctrlrange='-4 4' forcerange='-5 5'/>
                <velocity joint='slip' kv='7'/>%s</actuator></mujoco>
                """;
        RobotImport one = imported(robot.formatted(""));
        ItemDefinition hinge = items(one).get("hinge");
        assertThat(hinge.physics("motorDamping").orElseThrow()).containsExactly(12);
        assertThat(hinge.physics("motorTorque").orElseThrow()).containsExactly(10);
        assertThat(hinge.physics("motorStiffness")).isEmpty();
        assertThat(hinge.physics("motorSpeed")).isEmpty();
        ItemDefinition slip = items(one).get("slip");
        assertThat(slip.physics("driveDamping").orElseThrow()).containsExactly(7);
        assertThat(slip.physics("driveForce").orElseThrow()).containsExactly(1e5);
        assertThat(one.files().get("robot.yaml").replaceAll("\\s+", " "))
                .contains("speed: {unit: rad/s, min: -2, max: 2}")
                .doesNotContain("physics.motorDamping", "physics.driveDamping");
        assertThat(one.notes()).isEmpty();
        // The damping of a joint with a servo is stated even if it is 0, because an act sets it.
        RobotImport servo = imported(robot.formatted("<position joint='slip' kp='4'/>"));
        assertThat(items(servo).get("slip").physics("driveDamping").orElseThrow())
                .containsExactly(0);
        assertThat(servo.files().get("robot.yaml")).contains("{set: physics.driveDamping, to: 7}");
        // A second actuator of the joint has no damping, so each act sets it.
        String two = imported(robot.formatted("<motor joint='hinge'/>")).files().get("robot.yaml");
        assertThat(two)
                .contains(
                        "{set: physics.motorDamping, to: 12}", "{set: physics.motorDamping, to: 0}")
                .doesNotContain("physics.motorStiffness");
    }

    @Test
    void theWorldHasTheGravityAndAtMostTheTimeStepOfTheFile() throws Exception {
        RobotImport robot = imported(ROBOT);
        assertThat(robot.files().get("world.yaml"))
                .contains(
                        "gravity: [1.0, -3.0, -2.0]",
                        "frame: {rate: 60, steps: 34}",
                        "parameters: {friction: 0.9}");
        String off = ROBOT.replace("solver=\"CG\"/>", "><flag gravity=\"disable\"/></option>");
        assertThat(imported(off).files().get("world.yaml")).contains("gravity: [0.0, 0.0, 0.0]");
    }

    @Test
    void severalJointsOfABodyHaveBodiesBetweenThem() throws Exception {
        RobotImport robot =
                imported(
                        "<mujoco><worldbody><body name='a'><joint name='x' type='slide' axis='1 0"
                                + " 0'/><joint name='y' type='slide' axis='0 1 0'/><joint name='z'/>"
                                + "<geom size='1' mass='5'/></body></worldbody></mujoco>");
        Map<String, ItemDefinition> items = items(robot);
        double mass = 0;
        for (String name : new String[] {"a", "a link 1", "a link 2"}) {
            mass += items.get(name).physics("mass").orElseThrow()[0];
        }
        assertThat(mass).isCloseTo(5, within(1e-12));
        assertThat(items.get("x").references().get("joined")).containsExactly("base", "a link 1");
        assertThat(items.get("z").references().get("joined")).containsExactly("a link 2", "a");
        assertThat(robot.notes())
                .containsExactly(
                        "body a: it has 3 joints; bodies between them have 2 % of its mass each");
    }

    @Test
    void aFixedBaseHasNoFreeJoints() throws Exception {
        Map<String, ItemDefinition> fixed = items(imported(ROBOT, RobotImport.Base.FIXED));
        assertThat(fixed).doesNotContainKey("trunk look 2");
        assertThat(fixed.get("trunk").physics("mass").orElseThrow()).containsExactly(0);
        String welded = ROBOT.replace("<freejoint/>", "");
        assertThat(imported(welded, RobotImport.Base.FREE).notes())
                .contains("--base free has no effect: no body has a free joint in the file");
    }

    @Test
    void includedFilesAreReadFromTheFolderOnce() throws Exception {
        Files.createDirectories(folder.resolve("parts"));
        Files.writeString(
                folder.resolve("parts/ball.xml"),
                "<mujocoinclude>\n<geom size='1' mass='3'/></mujocoinclude>");
        String one = "<include file='parts/ball.xml'/>";
        String robot =
                "<mujoco><worldbody><body name='a'><freejoint/>%s</body></worldbody></mujoco>";
        assertThat(items(imported(robot.formatted(one))).get("a").physics("mass").orElseThrow())
                .containsExactly(new double[] {3}, within(1e-12));
        assertThatThrownBy(() -> imported(robot.formatted(one + one)))
                .hasMessageEndingWith(
                        "robot.xml:1: the file parts/ball.xml is included twice; a file may be"
                                + " included once");
        Files.writeString(
                folder.resolve("parts/ball.xml"),
                "<mujocoinclude>\n<geom size='x'/></mujocoinclude>");
        assertThatThrownBy(() -> imported(robot.formatted(one)))
                .hasMessageContaining("parts/ball.xml:2: <geom size=\"x\">: expected");
        for (String outside : new String[] {"../x.xml", "/etc/hostname"}) {
            assertThatThrownBy(() -> imported(robot.formatted("<include file='" + outside + "'/>")))
                    .isInstanceOf(RobotFileException.class)
                    .hasMessageContaining("robot.xml:1: ");
        }
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            value = {
                "<mujoco/> | <worldbody> has neither a <body> nor a <geom>",
                "<!DOCTYPE m [<!ENTITY e SYSTEM 'file:///etc/hostname'>]><mujoco>&e;</mujoco> |"
                        + " this is not XML",
                "<mujoco><compiler angle='turn'/></mujoco> | angle is turn, expected degree or radian",
                "<mujoco><compiler coordinate='global'/></mujoco> | coordinate is global, expected local",
                "<mujoco><compiler eulerseq='xyw'/></mujoco> | eulerseq is xyw",
                "<mujoco><option timestep='0'/><worldbody><geom size='1'/></worldbody></mujoco> |"
                        + " timestep is 0.0 s",
                "<mujoco><worldbody><joint/></worldbody></mujoco> | <joint> is outside of a body",
                "<mujoco><worldbody><geom size='-1'/></worldbody></mujoco> | a length is -1.0 m",
                "<mujoco><worldbody><body name='a'><joint/><geom size='1e300'/></body></worldbody></mujoco>"
                        + " | a length is 1.0E300 m, expected more than 0 and at most 1e11 m",
                "<mujoco><worldbody><geom type='torus' size='1'/></worldbody></mujoco> | the type"
                        + " torus is unknown",
                "<mujoco><worldbody><geom class='x' size='1'/></worldbody></mujoco> | there is no"
                        + " default class x",
                "<mujoco><worldbody><geom type='mesh' mesh='x'/></worldbody></mujoco> | there is no"
                        + " mesh x",
                "<mujoco><worldbody><geom size='1' quat='0 0 0 0'/></worldbody></mujoco> | the"
                        + " quaternion is 0 0 0 0",
                "<mujoco><worldbody><geom size='1' euler='0 0 0' zaxis='0 0 1'/></worldbody></mujoco>"
                        + " | states its orientation twice",
                "<mujoco><worldbody><body name='a'><joint range='2 1'/></body></worldbody></mujoco>"
                        + " | range is from 2.0 to 1.0",
                "<mujoco><worldbody><body name='a'><joint type='free'/><joint/></body></worldbody></mujoco>"
                        + " | a free joint",
                "<mujoco><worldbody><body name='a'/><body name='a'/></worldbody></mujoco> | a second"
                        + " body has the name a",
                "<mujoco><worldbody><body name='a'><joint/><geom type='plane' size='1'/></body></worldbody></mujoco>"
                        + " | a plane is on a body that moves",
                "<mujoco><worldbody><geom size='1' condim='2'/></worldbody></mujoco> | condim is 2.0,"
                        + " expected 1, 3, 4 or 6",
                "<mujoco><worldbody><geom size='1' friction='1 -1'/></worldbody></mujoco> | the"
                        + " friction is -1.0, expected 0 or more",
                "<mujoco><worldbody><body name='a'><joint damping='-1'/></body></worldbody></mujoco>"
                        + " | damping is -1.0, expected 0 or more",
                "<mujoco><worldbody><geom size='1'/></worldbody><actuator><motor"
                        + " joint='x'/></actuator></mujoco> | there is no joint x",
                "<mujoco><default><default class='a'/><default class='a'/></default></mujoco> | a"
                        + " second default class has the name a"
            })
    void whatIsNoModelIsRefusedAtItsLine(String robot, String reason) {
        assertThatThrownBy(() -> imported("\n" + robot))
                .isInstanceOf(RobotFileException.class)
                .hasMessageContaining("robot.xml:")
                .hasMessageContaining(reason);
    }

    @Test
    void damagedFilesAreImportedOrRefused() throws Exception {
        Random random = new Random(Seed.of("mjcf"));
        for (int i = 0; i < 300; i++) {
            byte[] bytes = ROBOT.getBytes(StandardCharsets.UTF_8);
            for (int change = random.nextInt(4); change >= 0; change--) {
                bytes[random.nextInt(bytes.length)] = (byte) (32 + random.nextInt(95));
            }
            String robot = new String(bytes, StandardCharsets.UTF_8);
            try {
                items(imported(robot));
            } catch (RobotFileException refused) {
                assertThat(refused.getMessage()).contains("robot.xml:");
            } catch (IOException | RuntimeException broken) {
                throw new AssertionError(robot, broken);
            }
        }
    }

    @Test
    void aLinearCouplingOfTwoJointsIsAGear() throws Exception {
        String file =
                """
                <mujoco>
                  <worldbody>
                    <body name="a"><joint name="one"/><geom size="0.1"/>
                      <body name="b" pos="1 0 0"><joint name="two" type="slide"/><geom size="0.1"/></body>
                    </body>
                  </worldbody>
                  <equality>
                    <joint joint1="two" joint2="one" polycoef="0.1 0.3 0 0 0" solref="0.1 1"/>
                    <joint joint1="two" joint2="one" polycoef="0 1 2 0 0"/>
                    <joint joint1="two"/>
                    <weld body1="a"/>
                  </equality>
                </mujoco>
                """;
        RobotImport robot = imported(file);
        ItemDefinition gear = items(robot).get("two gear");
        assertThat(gear.references().get("geared")).containsExactly("two", "one");
        assertThat(gear.physics("gearRatio").orElseThrow()).containsExactly(0.3);
        assertThat(gear.physics("offsetTravel").orElseThrow()).containsExactly(0.1);
        assertThat(robot.notes())
                .contains(
                        "not imported: <equality> <joint> of one joint or not active",
                        "not imported: <equality> <joint> that is not linear",
                        "not imported: <equality> <weld>",
                        "not imported: solref of <joint>");
        assertThatThrownBy(() -> imported(file.replace("joint2=\"one\"", "joint2=\"no\"")))
                .hasMessageContaining("there is no joint no");
    }
}
