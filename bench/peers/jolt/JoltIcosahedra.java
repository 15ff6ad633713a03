// SPDX-License-Identifier: Apache-2.0
import com.github.stephengold.joltjni.*;
import com.github.stephengold.joltjni.enumerate.EActivation;
import com.github.stephengold.joltjni.enumerate.EBendType;
import com.github.stephengold.joltjni.enumerate.EMotionType;
import com.github.stephengold.joltjni.readonly.ConstVertexAttributes;
import com.sun.management.OperatingSystemMXBean;

import java.io.IOException;
import java.lang.management.ManagementFactory;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.regex.Pattern;

/**
 * The world of bench/icosahedra as soft bodies of Jolt, with 5 iterations per step. Measures frames
 * of 1/60 s per second.
 *
 * <p>java JoltIcosahedra LIBRARY THREADS SCENE. The scene (worlds/icosahedron/solid.vesper) has the
 * faces. Prints a line of JSON.
 */
public final class JoltIcosahedra {
    private static final int ICOSAHEDRA = 1000;
    private static final int SETTLE = 60;
    private static final int FRAMES = 300;
    private static final int MOVING = 0;
    private static final int FIXED = 1;

    private static final int FACES = 20;
    private static final Pattern FACE = Pattern.compile("\\((\\d+) (\\d+) (\\d+)\\)");

    public static void main(String[] arguments) throws IOException {
        System.load(arguments[0]);
        int threads = Integer.parseInt(arguments[1]);
        Jolt.registerDefaultAllocator();
        Jolt.newFactory();
        Jolt.registerTypes();
        TempAllocator memory = new TempAllocatorImpl(256 << 20);
        JobSystem jobs =
                threads == 1
                        ? new JobSystemSingleThreaded(Jolt.cMaxPhysicsJobs)
                        : new JobSystemThreadPool(
                                Jolt.cMaxPhysicsJobs, Jolt.cMaxPhysicsBarriers, threads - 1);
        PhysicsSystem system = world(faces(Path.of(arguments[2])));
        for (int frame = 0; frame < SETTLE; frame++) {
            system.update(1 / 60f, 1, memory, jobs);
        }
        long start = System.nanoTime();
        long processor = processorNanoseconds();
        for (int frame = 0; frame < FRAMES; frame++) {
            system.update(1 / 60f, 1, memory, jobs);
        }
        double wall = 1e-9 * (System.nanoTime() - start);
        double busy = 1e-9 * (processorNanoseconds() - processor);
        System.out.printf(
                "{\"framesPerSecond\": %.2f, \"framesPerProcessorSecond\": %.2f, "
                        + "\"meanHeight\": %.4f}%n",
                FRAMES / wall, FRAMES / busy, meanHeight(system));
        System.exit(0);
    }

    /** Returns the mean height of the bodies' centres [m]. */
    private static double meanHeight(PhysicsSystem system) {
        double sum = 0;
        BodyIdVector ids = new BodyIdVector();
        system.getBodies(ids);
        for (int i = 1; i < ids.size(); i++) {
            sum += system.getBodyInterface().getCenterOfMassPosition(ids.get(i)).yy();
        }
        return sum / (ids.size() - 1);
    }

    private static long processorNanoseconds() {
        return ((OperatingSystemMXBean) ManagementFactory.getOperatingSystemMXBean())
                .getProcessCpuTime();
    }

    /** Returns the corners of each face, counter-clockwise as seen from outside. */
    private static List<int[]> faces(Path scene) throws IOException {
        String line =
                Files.readAllLines(scene).stream()
                        .filter(text -> text.startsWith("vertices "))
                        .findFirst()
                        .orElseThrow();
        return FACE.matcher(line)
                .results()
                .limit(FACES) // the faces of the ground follow
                .map(
                        face ->
                                new int[] {
                                    Integer.parseInt(face.group(1)),
                                    Integer.parseInt(face.group(2)),
                                    Integer.parseInt(face.group(3))
                                })
                .toList();
    }

    private static PhysicsSystem world(List<int[]> faces) {
        var system = new PhysicsSystem();
        system.init(
                ICOSAHEDRA + 16,
                0,
                65536,
                65536,
                new MapObj2Bp(2, 2).add(MOVING, MOVING).add(FIXED, FIXED),
                new ObjVsBpFilter(2, 2).disablePair(MOVING, MOVING),
                new ObjVsObjFilter(2).disablePair(MOVING, MOVING));
        system.setGravity(0f, -9.81f, 0f);
        BodyInterface bodies = system.getBodyInterface();
        bodies.createAndAddBody(
                new BodyCreationSettings(
                        new BoxShape(new Vec3(500f, 1f, 500f)),
                        new RVec3(0, -1, 0),
                        new Quat(),
                        EMotionType.Static,
                        FIXED),
                EActivation.DontActivate);
        SoftBodySharedSettings icosahedron = icosahedron(faces);
        int side = (int) Math.round(Math.sqrt(ICOSAHEDRA));
        for (int i = 0; i < ICOSAHEDRA; i++) {
            var place = new RVec3(10.0 * (i % side - side / 2), 1.2, 10.0 * (i / side - side / 2));
            var body = new SoftBodyCreationSettings(icosahedron, place, new Quat(), MOVING);
            body.setAllowSleeping(false);
            body.setFriction(0.5f);
            body.setNumIterations(5);
            bodies.createAndAddSoftBody(body, EActivation.Activate);
        }
        system.optimizeBroadPhase();
        return system;
    }

    private static SoftBodySharedSettings icosahedron(List<int[]> faces) {
        var settings = new SoftBodySharedSettings();
        float s = (float) Math.sqrt((5 - Math.sqrt(5)) / 10);
        float l = (float) Math.sqrt((5 + Math.sqrt(5)) / 10);
        for (int turn = 0; turn < 3; turn++) {
            for (int corner = 0; corner < 4; corner++) {
                float[] p = {corner % 2 == 0 ? -s : s, corner < 2 ? l : -l, 0};
                var vertex = new Vertex();
                vertex.setPosition(
                        new Vec3(p[(3 - turn) % 3], p[(4 - turn) % 3], p[(5 - turn) % 3]));
                vertex.setInvMass(1f);
                settings.addVertex(vertex);
            }
        }
        for (int[] face : faces) {
            var triangle = new Face();
            for (int i = 0; i < 3; i++) {
                triangle.setVertex(i, face[i]);
            }
            settings.addFace(triangle);
        }
        var edges = new VertexAttributes(1f / 5000, 1f / 5000, Float.MAX_VALUE);
        settings.createConstraints(new ConstVertexAttributes[] {edges}, EBendType.None);
        settings.optimize();
        return settings;
    }
}
