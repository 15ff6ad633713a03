// SPDX-License-Identifier: Apache-2.0
import com.github.stephengold.joltjni.*;
import com.github.stephengold.joltjni.enumerate.EActivation;
import com.github.stephengold.joltjni.enumerate.EMotionType;
import com.github.stephengold.joltjni.enumerate.EOverrideMassProperties;

import java.io.IOException;
import java.io.PrintStream;
import java.lang.management.ManagementFactory;
import java.util.ArrayList;
import java.util.List;

/**
 * The scenes of bench/bodies as rigid bodies of Jolt. Measures frames of 1/60 s per second.
 *
 * <p>java JoltBodies LIBRARY SCENE BOXES STEPS SLEEP POSES. Prints a line of JSON.
 */
public final class JoltBodies {
    private static final int LAYERS = 10;
    private static final int TIMED = 60;
    private static final int MOVING = 0;
    private static final int FIXED = 1;

    private final PhysicsSystem system = new PhysicsSystem();
    private final List<Integer> boxes = new ArrayList<>();
    private final boolean sleeps;
    private int settle = 120;
    private int state = 1;

    public static void main(String[] arguments) throws IOException {
        System.load(arguments[0]);
        Jolt.registerDefaultAllocator();
        Jolt.newFactory();
        Jolt.registerTypes();
        TempAllocator memory = new TempAllocatorImpl(256 << 20);
        JobSystem jobs = new JobSystemSingleThreaded(Jolt.cMaxPhysicsJobs);
        boolean sleeps = Double.parseDouble(arguments[4]) > 0;
        int steps = Integer.parseInt(arguments[3]);
        var bench = new JoltBodies(arguments[1], Integer.parseInt(arguments[2]), sleeps);
        int settle = sleeps ? 600 : bench.settle;
        int timed = sleeps ? 10 * TIMED : TIMED;
        for (int frame = 0; frame < settle; frame++) {
            bench.system.update(1 / 60f, steps, memory, jobs);
        }
        long start = System.nanoTime();
        long processor = processorNanoseconds();
        for (int frame = 0; frame < timed; frame++) {
            bench.system.update(1 / 60f, steps, memory, jobs);
        }
        double busy = 1e-9 * (processorNanoseconds() - processor);
        double wall = 1e-9 * (System.nanoTime() - start);
        bench.write(arguments[5]);
        System.out.printf(
                "{\"framesPerSecond\": %.3f, \"framesPerProcessorSecond\": %.3f}%n",
                timed / wall, timed / busy);
        System.exit(0);
    }

    private static long processorNanoseconds() {
        // Only this thread computes. The JIT compiler has other threads, which do not count.
        return ManagementFactory.getThreadMXBean().getCurrentThreadCpuTime();
    }

    private JoltBodies(String scene, int count, boolean sleeps) {
        this.sleeps = sleeps;
        system.init(
                count + 16,
                0,
                count * 32 + 1024,
                count * 32 + 1024,
                new MapObj2Bp(2, 2).add(MOVING, MOVING).add(FIXED, FIXED),
                new ObjVsBpFilter(2, 2).disablePair(FIXED, FIXED),
                new ObjVsObjFilter(2).disablePair(FIXED, FIXED));
        system.setGravity(0f, -9.81f, 0f);
        var floor =
                new BodyCreationSettings(
                        new BoxShape(new Vec3(500f, 1f, 500f)),
                        new RVec3(0, -1, 0),
                        new Quat(),
                        EMotionType.Static,
                        FIXED);
        floor.setFriction(0.5f);
        system.getBodyInterface().createAndAddBody(floor, EActivation.DontActivate);
        var box = new BoxShape(new Vec3(0.5f, 0.5f, 0.5f));
        if (scene.equals("pile")) {
            int side = Math.max(1, (int) Math.round(Math.sqrt(count / (double) LAYERS)));
            for (int i = 0; i < count; i++) {
                double x = jittered(i % side);
                double z = jittered(i / side % side);
                add(box, 1, x, 0.6 + jittered(i / side / side), z);
            }
        } else if (scene.equals("stacks")) {
            int side = Math.max(1, (int) Math.round(Math.sqrt(count / (double) LAYERS)));
            for (int i = 0; i < count; i++) {
                int stack = i / LAYERS;
                add(box, 1, 3.0 * (stack % side), 0.5 + i % LAYERS, 3.0 * (stack / side));
            }
        } else { // wall
            settle = 0;
            int side = (int) Math.round(Math.sqrt(count));
            for (int i = 0; i < count; i++) {
                int row = i / side;
                add(box, 1, i % side + 0.5 * (row % 2) - 0.5 * side, 0.5 + row, 0);
            }
            int ball = add(new SphereShape(1f), 40, 0, 5, -6);
            boxes.remove(boxes.size() - 1);
            system.getBodyInterface().setLinearVelocity(ball, new Vec3(0f, 0f, 20f));
        }
        system.optimizeBroadPhase();
    }

    private int add(Shape shape, double mass, double x, double y, double z) {
        var settings =
                new BodyCreationSettings(
                        shape, new RVec3(x, y, z), new Quat(), EMotionType.Dynamic, MOVING);
        settings.setAllowSleeping(sleeps);
        settings.setFriction(0.5f);
        settings.setLinearDamping(0f);
        settings.setAngularDamping(0f);
        settings.setOverrideMassProperties(EOverrideMassProperties.CalculateInertia);
        settings.getMassPropertiesOverride().setMass((float) mass);
        int id = system.getBodyInterface().createAndAddBody(settings, EActivation.Activate);
        boxes.add(id);
        return id;
    }

    private double jittered(int i) {
        state = state * 1664525 + 1013904223;
        return 1.1 * i + 0.1 * (Integer.toUnsignedLong(state) / 4294967296.0 - 0.5);
    }

    /** Writes the poses of all boxes: place and quaternion. */
    private void write(String file) throws IOException {
        BodyInterface bodies = system.getBodyInterface();
        try (var out = new PrintStream(file)) {
            for (int id : boxes) {
                RVec3 at = bodies.getPosition(id);
                Quat q = bodies.getRotation(id);
                out.println(
                        String.join(
                                " ",
                                String.valueOf(at.xx()),
                                String.valueOf(at.yy()),
                                String.valueOf(at.zz()),
                                String.valueOf(q.getX()),
                                String.valueOf(q.getY()),
                                String.valueOf(q.getZ()),
                                String.valueOf(q.getW())));
            }
            out.println();
        }
    }
}
