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
import reve.core.world.Pose;
import reve.core.world.Shape;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.stream.Collectors;

/**
 * Robots as worlds. Bodies, joints and meshes are compared with closed forms, and wrong files are
 * refused.
 */
class RobotImportTest {
    private static final RobotImport.Options USUAL =
            new RobotImport.Options(RobotImport.Base.AUTOMATIC, true, false, false, Map.of());
    private static final RobotImport.Options Y_UP =
            new RobotImport.Options(RobotImport.Base.FREE, false, false, false, Map.of());

    /** The triangles of a cube, by the bits of its corners, counter-clockwise from outside. */
    private static final int[] CUBE = {
        0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1,
        3, 7, 1, 7, 5
    };

    @TempDir private Path folder;

    private RobotImport imported(String robot, RobotImport.Options options) throws Exception {
        Path file = folder.resolve("robot.urdf");
        Files.writeString(file, robot);
        return RobotImport.read(file, options);
    }

    /** Returns the items of the world that was written, by name. */
    private Map<String, ItemDefinition> items(RobotImport robot) throws Exception {
        Path out = folder.resolve("out");
        robot.write(out);
        WorldDescription world = WorldFile.loadFolder(out);
        return world.items().stream().collect(Collectors.toMap(ItemDefinition::name, item -> item));
    }

    /** The content of a device would fill the memory, and reading a pipe would block. */
    @Test
    void onlyARegularFileIsRead() throws Exception {
        Path zeros = Files.createSymbolicLink(folder.resolve("x.urdf"), Path.of("/dev/zero"));
        assertThatThrownBy(() -> RobotImport.read(zeros, USUAL))
                .isInstanceOf(RobotFileException.class)
                .hasMessage(zeros + ": expected a regular file");
    }

    private static Pose pose(ItemDefinition item) {
        return Pose.of(item.location(), item.orientation());
    }

    private static String inertial(String origin, double mass, double... moments) {
        return "<inertial><origin %s/><mass value=\"%s\"/><inertia ixx=\"%s\" iyy=\"%s\" izz=\"%s\"/></inertial>"
                .formatted(origin, mass, moments[0], moments[1], moments[2]);
    }

    /** Two neighbouring cubes of 1 m and 3 kg are a box of 2 m and 6 kg. */
    @Test
    void rigidJointsMakeOneBodyWithTheInertiaOfBoth() throws Exception {
        String cube = inertial("xyz=\"0 0 0\"", 3, 0.5, 0.5, 0.5);
        RobotImport robot =
                imported(
                        "<robot name=\"two\"><link name=\"a\">"
                                + cube
                                + "</link><link name=\"b\">"
                                + cube
                                + "</link><joint name=\"j\" type=\"fixed\"><origin xyz=\"1 0 0\""
                                + " rpy=\"1 2 3\"/><parent link=\"a\"/><child link=\"b\"/></joint></robot>",
                        Y_UP);
        assertThat(robot.bodies()).isEqualTo(1);
        assertThat(robot.joints()).isZero();
        ItemDefinition body = items(robot).get("a");
        MassProperties box = MassProperties.of(Shape.box(2, 1, 1), 3);
        assertThat(body.location()).containsExactly(new double[] {0.5, 0, 0}, within(1e-12));
        assertThat(body.physics("mass").orElseThrow()).containsExactly(6);
        assertThat(body.physics("inertia").orElseThrow())
                .containsExactly(box.moments(), within(1e-9));
    }

    /**
     * The moments and axes of an item are those of the inertia, which may be rotated in the file.
     */
    @Test
    void itemsHaveThePrincipalAxesOfTheirInertia() throws Exception {
        Random random = new Random(Seed.of("inertia"));
        for (int i = 0; i < 50; i++) {
            double[] moments = {1 + random.nextDouble(), 2, 1.5 + random.nextDouble()};
            double[] rpy = new double[3];
            for (int axis = 0; axis < 3; axis++) {
                rpy[axis] = 4 * random.nextDouble() - 2;
            }
            Pose turn = Pose.of(new double[3], UrdfReader.ofAngles(rpy[0], rpy[1], rpy[2]));
            double[] inertia =
                    new SymmetricMatrix(new double[] {moments[0], moments[1], moments[2], 0, 0, 0})
                            .turned(turn)
                            .values();
            String robot =
                    ("<robot name=\"r\"><link name=\"a\"><inertial><origin xyz=\"1 2 3\"/><mass"
                                    + " value=\"4\"/><inertia ixx=\"%s\" iyy=\"%s\" izz=\"%s\""
                                    + " iyz=\"%s\" ixz=\"%s\" ixy=\"%s\"/></inertial></link></robot>")
                            .formatted(
                                    inertia[0],
                                    inertia[1],
                                    inertia[2],
                                    inertia[3],
                                    inertia[4],
                                    inertia[5]);
            ItemDefinition item = items(imported(robot, Y_UP)).get("a");
            assertThat(item.location()).containsExactly(1, 2, 3);
            double[] found = item.physics("inertia").orElseThrow();
            assertThat(found).containsExactly(sortedLike(found, moments), within(1e-9));
            double[] back =
                    new SymmetricMatrix(new double[] {found[0], found[1], found[2], 0, 0, 0})
                            .turned(Pose.of(new double[3], item.orientation()))
                            .values();
            assertThat(back).containsExactly(inertia, within(1e-9));
        }
    }

    private static double[] sortedLike(double[] order, double[] values) {
        double[] result = new double[order.length];
        for (int i = 0; i < order.length; i++) {
            int rank = rank(order, i);
            for (int j = 0; j < values.length; j++) {
                if (rank(values, j) == rank) {
                    result[i] = values[j];
                }
            }
        }
        return result;
    }

    private static int rank(double[] values, int at) {
        int rank = 0;
        for (double value : values) {
            rank += value < values[at] ? 1 : 0;
        }
        return rank;
    }

    private static final String ARM =
            "<robot name=\"arm\"><link name=\"world\"/><link name=\"upper\">"
                    + inertial("xyz=\"0.2 0 0\"", 2, 0.02, 0.03, 0.03)
                    + "<collision><origin xyz=\"0.2 0 0\" rpy=\"0 1.5707963267948966 0\"/>"
                    + "<geometry><cylinder radius=\"0.05\" length=\"0.4\"/></geometry></collision>"
                    + "</link><link name=\"slide\">"
                    + inertial("xyz=\"0 0 0\"", 1, 0.01, 0.01, 0.01)
                    + "<visual><geometry><sphere radius=\"0.1\"/></geometry><material name=\"m\">"
                    + "<color rgba=\"1 0 0 1\"/></material></visual>"
                    + "<collision><geometry><box size=\"0.1 0.2 0.3\"/></geometry></collision></link>"
                    + "<joint name=\"shoulder\" type=\"revolute\"><origin xyz=\"0 0 1\""
                    + " rpy=\"0 0 1.5707963267948966\"/><parent link=\"world\"/><child"
                    + " link=\"upper\"/><axis xyz=\"0 2 0\"/><limit lower=\"-1\" upper=\"2\""
                    + " effort=\"30\" velocity=\"4\"/><dynamics friction=\"0.5\""
                    + " damping=\"1\"/></joint>"
                    + "<joint name=\"rail\" type=\"prismatic\"><origin xyz=\"0.4 0 0\"/><parent"
                    + " link=\"upper\"/><child link=\"slide\"/><limit lower=\"0\" upper=\"0.3\""
                    + " effort=\"0\" velocity=\"0\"/><mimic joint=\"shoulder\" multiplier=\"-0.1\""
                    + " offset=\"0.05\"/></joint>"
                    + "<transmission/><gazebo/><gazebo/></robot>";

    @Test
    void aRobotHasBodiesShapesAndJointsInTheAxesOfTheWorld() throws Exception {
        RobotImport robot = imported(ARM, USUAL);
        assertThat(robot.bodies()).isEqualTo(3);
        assertThat(robot.joints()).isEqualTo(2);
        assertThat(robot.notes())
                .containsExactly(
                        "joint rail: it is at 0 at the start, and then moves to its offset 0.05",
                        "not imported: <gazebo> (2 times)",
                        "not imported: <transmission>");
        Map<String, ItemDefinition> items = items(robot);
        assertThat(items.get("shoulder").physics("angleDamping").orElseThrow()).containsExactly(1);
        assertThat(items.get("shoulder").physics("angleFriction").orElseThrow())
                .containsExactly(0.5);
        assertThat(items.get("base").physics("mass").orElseThrow()).containsExactly(0);
        // After the turn about +Z, the x axis of the file is the -z axis of the robot, and the z
        // axis of the file is +Y.
        assertThat(items.get("upper").location())
                .containsExactly(new double[] {0, 1, -0.2}, within(1e-12));
        ItemDefinition cylinder = items.get("upper shape");
        assertThat(cylinder.parent()).contains("upper");
        assertThat(cylinder.physics("partOfBody").orElseThrow()).containsExactly(1);
        // The law reads the layers of the shapes, not of the body that has them.
        assertThat(cylinder.physics("touchLayer").orElseThrow()).containsExactly(1);
        assertThat(cylinder.physics("passesLayers").orElseThrow()).containsExactly(2);
        Pose end =
                new Pose(0, 0.2, 0, 0, 0, 0, 1)
                        .within(pose(cylinder))
                        .within(pose(items.get("upper")));
        assertThat(Math.abs(end.z() + 0.2)).isCloseTo(0.2, within(1e-12));
        assertThat(end.y()).isCloseTo(1, within(1e-12));
        assertThat(items.get("slide look").colour()).hasToString("#ff0000ff");
        assertThat(items.get("slide look").hasPhysics()).isFalse();
        assertThat(items.get("slide shape").colour()).hasToString("#00000000");

        ItemDefinition shoulder = items.get("shoulder");
        assertThat(shoulder.references().get("joined")).containsExactly("base", "upper");
        assertThat(shoulder.physics("angleLimits").orElseThrow()).containsExactly(-1, 2);
        assertThat(shoulder.physics("angleFriction").orElseThrow()).containsExactly(0.5);
        Pose base = pose(items.get("base"));
        double[] axis = shoulder.physics("axis").orElseThrow();
        Pose inWorld = new Pose(axis[0], axis[1], axis[2], 0, 0, 0, 1).within(base);
        // +Y of the joint is -X of the file, and so of the world.
        assertThat(inWorld.location()).containsExactly(new double[] {-1, 0, 0}, within(1e-9));
        double[] anchor = items.get("rail").physics("anchor").orElseThrow();
        assertThat(
                        new Pose(anchor[0], anchor[1], anchor[2], 0, 0, 0, 1)
                                .within(pose(items.get("upper")))
                                .location())
                .containsExactly(new double[] {0, 1, -0.4}, within(1e-9));
        assertThat(items.get("rail").physics("travelLimits").orElseThrow()).containsExactly(0, 0.3);
        assertThat(items.get("rail").actions()).as("of a joint that mimics another one").isEmpty();
        assertThat(shoulder.actions())
                .singleElement()
                .satisfies(action -> assertThat(action.name()).isEqualTo("drive"));
        ItemDefinition gear = items.get("rail gear");
        assertThat(gear.kind()).isEqualTo("gear");
        assertThat(gear.references().get("geared")).containsExactly("rail", "shoulder");
        assertThat(gear.physics("gearRatio").orElseThrow()).containsExactly(-0.1);
        assertThat(gear.physics("offsetTravel").orElseThrow()).containsExactly(0.05);
    }

    @Test
    void aJointThatMimicsNoOtherJointIsRefused() {
        assertThatThrownBy(
                        () ->
                                imported(
                                        ARM.replace("mimic joint=\"shoulder", "mimic joint=\"hip"),
                                        USUAL))
                .isInstanceOf(RobotFileException.class)
                .hasMessageContaining("the joint rail mimics hip, which is no joint of the file");
        assertThatThrownBy(
                        () ->
                                imported(
                                        ARM.replace("mimic joint=\"shoulder", "mimic joint=\"rail"),
                                        USUAL))
                .isInstanceOf(RobotFileException.class)
                .hasMessageContaining("the joint rail mimics itself");
    }

    @Test
    void theCouplingOfARigidJointIsNotImported() throws Exception {
        RobotImport robot =
                imported(ARM.replace("lower=\"-1\" upper=\"2\"", "lower=\"0\" upper=\"0\""), USUAL);
        assertThat(robot.notes())
                .contains(
                        "joint rail: its coupling to shoulder is not imported, because one of the two"
                                + " is no hinge or slider");
        assertThat(items(robot)).doesNotContainKey("rail gear");
    }

    @Test
    void aRobotWithAMassAtItsRootIsFreeAndStandsOnTheGround() throws Exception {
        String ball =
                "<robot name=\"ball\"><link name=\"ball\">"
                        + inertial("xyz=\"0 0 0\"", 2, 1, 1, 1)
                        + "<collision><geometry><sphere radius=\"0.5\"/></geometry></collision>"
                        + "</link></robot>";
        Map<String, ItemDefinition> items = items(imported(ball, USUAL));
        assertThat(items.get("ball").physics("mass").orElseThrow()).containsExactly(2);
        double top = items.get("ground").location()[1] + 0.5;
        assertThat(top).isCloseTo(-0.501, within(1e-9));
        var fixed = new RobotImport.Options(RobotImport.Base.FIXED, true, true, false, Map.of());
        ItemDefinition held = items(imported(ball, fixed)).get("ball");
        assertThat(held.physics("mass").orElseThrow()).containsExactly(0);
        assertThat(held.physics("touchLayer")).isEmpty();
        assertThat(items(imported(ball, fixed)).get("ball shape").physics("touchLayer")).isEmpty();
    }

    @Test
    void motorsHoldTheJointsIfTheyShall() throws Exception {
        var options =
                new RobotImport.Options(RobotImport.Base.AUTOMATIC, true, false, true, Map.of());
        Map<String, ItemDefinition> items = items(imported(ARM, options));
        assertThat(items.get("shoulder").physics("motorTorque").orElseThrow()).containsExactly(30);
        assertThat(items.get("rail").physics("driveForce"))
                .as("the file states no effort")
                .isEmpty();
    }

    @Test
    void movableLinksWithoutMassBelongToTheirParent() throws Exception {
        RobotImport robot =
                imported(
                        "<robot name=\"r\"><link name=\"a\">"
                                + inertial("xyz=\"0 0 0\"", 1, 1, 1, 1)
                                + "</link><link name=\"frame\"/><joint name=\"j\""
                                + " type=\"continuous\"><parent link=\"a\"/><child"
                                + " link=\"frame\"/></joint></robot>",
                        USUAL);
        assertThat(robot.bodies()).isEqualTo(1);
        assertThat(robot.notes())
                .containsExactly("joint j: the link frame has no mass, so it is a rigid part of a");
    }

    @Test
    void inertiaOfNoRealBodyIsReplacedAndNamed() throws Exception {
        RobotImport robot =
                imported(
                        "<robot name=\"r\"><link name=\"a\">"
                                + inertial("xyz=\"0 0 0\"", 1, 1, 1, 7)
                                + "</link></robot>",
                        Y_UP);
        assertThat(robot.notes())
                .singleElement()
                .asString()
                .contains("link a", "1.0, 1.0, 7.0", "mean");
        assertThat(items(robot).get("a").physics("inertia").orElseThrow()).containsExactly(3, 3, 3);
    }

    @ParameterizedTest
    @CsvSource({"true", "false"})
    void stlFilesBecomeMeshesAboutTheirCentre(boolean binary) throws Exception {
        Files.createDirectories(folder.resolve("meshes"));
        Files.write(folder.resolve("meshes/cube.stl"), binary ? binaryCube() : textCube());
        RobotImport robot =
                imported(
                        "<robot name=\"r\"><link name=\"a\">"
                                + inertial("xyz=\"0 0 0\"", 1, 1, 1, 1)
                                + "<collision><geometry><mesh filename=\"meshes/cube.stl\" scale=\"2"
                                + " -3 4\"/></geometry></collision></link></robot>",
                        Y_UP);
        assertThat(robot.notes()).isEmpty();
        ItemDefinition shape = items(robot).get("a shape");
        // The cube from 0 to 1 is a box from 0 to 2, -3 to 0 and 0 to 4.
        assertThat(shape.location()).containsExactly(new double[] {1, -1.5, 2}, within(1e-6));
        MassProperties solid = MassProperties.of(shape.shape(), 1);
        assertThat(solid.volume()).isCloseTo(24, within(1e-5));
        assertThat(solid.centre()).containsExactly(new double[3], within(1e-6));
    }

    /**
     * The unit of a COLLADA file counts, and its upward axis does not, because ROS ignores it. The
     * cube from 0 to 100 cm is a box from 0 to 2, 0 to 3 and 0 to 4.
     */
    @ParameterizedTest
    @CsvSource({"X_UP", "Y_UP", "Z_UP"})
    void colladaFilesKeepTheirAxes(String up) throws Exception {
        StringBuilder corners = new StringBuilder();
        for (int i = 0; i < 24; i++) {
            corners.append(100 * corner(i / 3, i % 3)).append(' ');
        }
        String faces = Arrays.stream(CUBE).mapToObj(i -> i + " ").collect(Collectors.joining());
        Files.writeString(
                folder.resolve("cube.dae"),
                """
                <COLLADA><asset><unit meter="0.01"/><up_axis>UP</up_axis></asset>
                <library_geometries><geometry id="g"><mesh>
                  <source id="s"><float_array id="a" count="24">CORNERS</float_array>
                    <technique_common><accessor source="#a" count="8" stride="3"/></technique_common></source>
                  <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
                  <triangles count="12"><input semantic="VERTEX" source="#v" offset="0"/><p>FACES</p></triangles>
                </mesh></geometry></library_geometries></COLLADA>
                """
                        .replace("UP</", up + "</")
                        .replace("CORNERS", corners)
                        .replace("FACES", faces));
        RobotImport robot =
                imported(
                        "<robot name=\"r\"><link name=\"a\">"
                                + inertial("xyz=\"0 0 0\"", 1, 1, 1, 1)
                                + "<collision><geometry><mesh filename=\"cube.dae\" scale=\"2 3 4\"/>"
                                + "</geometry></collision></link></robot>",
                        Y_UP);
        assertThat(robot.notes()).isEmpty();
        assertThat(robot.files()).containsKey("meshes/cube.obj");
        ItemDefinition shape = items(robot).get("a shape");
        assertThat(shape.location()).containsExactly(new double[] {1, 1.5, 2}, within(1e-6));
        assertThat(MassProperties.of(shape.shape(), 1).volume()).isCloseTo(24, within(1e-5));
    }

    private static float corner(int number, int axis) {
        return number >> axis & 1;
    }

    private static byte[] binaryCube() {
        ByteBuffer bytes =
                ByteBuffer.allocate(84 + 50 * CUBE.length / 3).order(ByteOrder.LITTLE_ENDIAN);
        bytes.put("solid, which text files begin with, too".getBytes(StandardCharsets.US_ASCII));
        bytes.position(80).putInt(CUBE.length / 3);
        for (int i = 0; i < CUBE.length; i += 3) {
            bytes.putFloat(0).putFloat(0).putFloat(0);
            for (int j = 0; j < 3; j++) {
                for (int axis = 0; axis < 3; axis++) {
                    bytes.putFloat(corner(CUBE[i + j], axis));
                }
            }
            bytes.putShort((short) 0);
        }
        return bytes.array();
    }

    private static byte[] textCube() {
        StringBuilder text = new StringBuilder("solid cube\n");
        for (int i = 0; i < CUBE.length; i += 3) {
            text.append("facet normal 0 0 0\n outer loop\n");
            for (int j = 0; j < 3; j++) {
                int number = CUBE[i + j];
                text.append("  vertex ").append(corner(number, 0)).append(' ');
                text.append(corner(number, 1)).append(' ').append(corner(number, 2)).append('\n');
            }
            text.append(" endloop\nendfacet\n");
        }
        return text.append("endsolid\n").toString().getBytes(StandardCharsets.US_ASCII);
    }

    @Test
    void meshesOfPackagesAreFoundAroundTheFileOrWhereTheOptionSays() throws Exception {
        String robot =
                "<robot name=\"r\"><link name=\"a\"><visual><geometry><mesh"
                        + " filename=\"package://arm/meshes/cube.stl\"/></geometry></visual></link></robot>";
        Path urdf = Files.createDirectories(folder.resolve("arm/urdf")).resolve("arm.urdf");
        Files.writeString(urdf, robot);
        assertThat(RobotImport.read(urdf, USUAL).notes())
                .singleElement()
                .asString()
                .contains(
                        "arm.urdf:1: mesh package://arm/meshes/cube.stl", "not found", "--package");
        Path elsewhere = Files.createDirectories(folder.resolve("elsewhere/meshes"));
        Files.write(elsewhere.resolve("cube.stl"), textCube());
        var options =
                new RobotImport.Options(
                        RobotImport.Base.AUTOMATIC,
                        true,
                        false,
                        false,
                        Map.of("arm", folder.resolve("elsewhere")));
        assertThat(RobotImport.read(urdf, options).notes()).isEmpty();
        Path own = Files.createDirectories(folder.resolve("arm/meshes"));
        Files.write(own.resolve("cube.stl"), textCube());
        RobotImport found = RobotImport.read(urdf, USUAL);
        assertThat(found.notes()).isEmpty();
        assertThat(found.files()).containsKey("meshes/cube.obj");
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            value = {
                "/etc/passwd.stl | leads out of the folder",
                "../../../x.stl | leads out of the folder",
                "file:///etc/x.stl | not found",
                "x.ply | format is not read",
                "broken.stl | not STL",
                "endless.stl | a coordinate is NaN",
                "word.stl | 'one' is no number"
            })
    void meshesThatCannotBeReadAreNamedAndLeftOut(String file, String reason) throws Exception {
        Files.writeString(folder.resolve("broken.stl"), "no mesh");
        Files.writeString(folder.resolve("word.stl"), "solid\nvertex one 2 3\n");
        byte[] cube = binaryCube();
        ByteBuffer.wrap(cube).order(ByteOrder.LITTLE_ENDIAN).putFloat(96, Float.NaN);
        Files.write(folder.resolve("endless.stl"), cube);
        RobotImport robot =
                imported(
                        "<robot name=\"r\"><link name=\"a\"><visual><geometry><mesh filename=\""
                                + file
                                + "\"/></geometry></visual></link></robot>",
                        USUAL);
        assertThat(robot.notes())
                .singleElement()
                .asString()
                .contains("robot.urdf:1: mesh " + file, reason, "left out");
        assertThat(items(robot)).containsOnlyKeys("a", "ground");
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            value = {
                "<robot> | 1: this is not XML",
                "<sdf/> | neither URDF nor MJCF: it begins with <sdf>, expected <robot> or <mujoco>",
                "<robot/> | the robot has no <link>",
                "<robot><link/></robot> | <link> has no attribute name",
                "<robot><link name='a'/><link name='a'/></robot> | a second link has the name a",
                "<robot><xacro:include xmlns:xacro='x' filename='y'/></robot> | xacro",
                "<robot><link name='a'><inertial><mass value='one'/><inertia/></inertial></link></robot>"
                        + " | <mass value=\"one\">: expected a number",
                "<robot><link name='a'><inertial><inertia/></inertial></link></robot>"
                        + " | <inertial> has no <mass>",
                "<robot><link name='a'><visual><geometry><torus/></geometry></visual></link></robot>"
                        + " | the shape <torus> is unknown",
                "<robot><link name='a'><visual><geometry><sphere radius='-1'/></geometry></visual></link></robot>"
                        + " | a length is -1.0 m",
                "<robot><link name='a'><visual><origin xyz='1 2'/><geometry><sphere"
                        + " radius='1'/></geometry></visual></link></robot>"
                        + " | expected 3 numbers",
                "<robot><link name='a'/><link name='b'/></robot> | the links a, b have no parent",
                "<robot><link name='a'/><joint name='j' type='fixed'><parent link='a'/><child"
                        + " link='c'/></joint></robot> | the child c is no link",
                "<robot><link name='a'/><link name='b'/><joint name='j' type='welded'><parent"
                        + " link='a'/><child link='b'/></joint></robot> | the type welded",
                "<robot><link name='a'/><link name='b'/><joint name='j' type='revolute'><parent"
                        + " link='a'/><child link='b'/></joint></robot> | needs a <limit>",
                "<robot><link name='a'/><link name='b'/><joint name='j' type='fixed'><parent"
                        + " link='a'/><child link='b'/></joint><joint name='k' type='fixed'><parent"
                        + " link='b'/><child link='a'/></joint></robot> | the joints form a ring",
                "<robot><link name='r'/><link name='a'/><link name='b'/><joint name='j'"
                        + " type='fixed'><parent link='a'/><child link='b'/></joint><joint name='k'"
                        + " type='fixed'><parent link='b'/><child link='a'/></joint></robot>"
                        + " | no joints lead from the root r to the link a",
                "<!DOCTYPE r [<!ENTITY x SYSTEM 'file:///etc/passwd'>]><robot name='&x;'><link"
                        + " name='a'/></robot> | this is not XML"
            })
    void wrongFilesAreRefusedAtTheirPlace(String robot, String message) {
        assertThatThrownBy(() -> imported(robot, USUAL))
                .isInstanceOf(RobotFileException.class)
                .hasMessageContaining("robot.urdf:1: ")
                .hasMessageContaining(message);
    }

    @Test
    void aRobotOfTooManyLinksIsRefused() {
        StringBuilder robot = new StringBuilder("<robot>");
        for (int i = 0; i < 1001; i++) {
            robot.append("<link name='").append(i).append("'/>");
        }
        assertThatThrownBy(() -> imported(robot.append("</robot>").toString(), USUAL))
                .isInstanceOf(RobotFileException.class)
                .hasMessageEndingWith(
                        "robot.urdf:1: the robot has 1001 links, expected at most 1000");
    }

    /** Files of a robot in which one byte is changed are imported or refused. */
    @Test
    void damagedFilesAreImportedOrRefused() throws Exception {
        Random random = new Random(Seed.of("damaged robots"));
        Path file = folder.resolve("robot.urdf");
        for (int i = 0; i < 500; i++) {
            byte[] bytes = ARM.getBytes(StandardCharsets.UTF_8);
            for (int j = random.nextInt(3); j >= 0; j--) {
                bytes[random.nextInt(bytes.length)] = (byte) (32 + random.nextInt(95));
            }
            Files.write(file, bytes);
            try {
                items(RobotImport.read(file, USUAL));
            } catch (RobotFileException refused) {
                assertThat(refused.getMessage()).startsWith(file + ":");
            } catch (IOException | RuntimeException broken) {
                throw new AssertionError(new String(bytes, StandardCharsets.UTF_8), broken);
            }
        }
    }

    @Test
    void namesThatAWorldRefusesAreChanged() throws Exception {
        Map<String, ItemDefinition> items =
                items(
                        imported(
                                "<robot name=\"?!\"><link name=\"world\"/><link name=\"a&#10;b\">"
                                        + inertial("xyz=\"0 0 0\"", 1, 1, 1, 1)
                                        + "</link><joint name=\"base\" type=\"continuous\"><parent"
                                        + " link=\"world\"/><child link=\"a&#10;b\"/></joint></robot>",
                                USUAL));
        assertThat(List.copyOf(items.keySet()))
                .containsExactlyInAnyOrder("base", "a_b", "base joint", "ground");
    }
}
