// SPDX-License-Identifier: Apache-2.0
import com.github.stephengold.joltjni.*;
import com.github.stephengold.joltjni.enumerate.EActivation;
import com.github.stephengold.joltjni.enumerate.EMotionType;
import com.sun.management.OperatingSystemMXBean;

import java.lang.management.ManagementFactory;
import java.util.Random;

/**
 * The world of bench/spheres as rigid bodies of Jolt. Measures frames of 1/60 s per second.
 *
 * <p>java JoltSpheres LIBRARY BODIES THREADS. Prints a line of JSON.
 */
public final class JoltSpheres {
    private static final int LAYERS = 10;
    private static final int SETTLE = 60;
    private static final int FRAMES = 20;
    private static final int MOVING = 0;
    private static final int FIXED = 1;

    public static void main(String[] arguments) {
        System.load(arguments[0]);
        int count = Integer.parseInt(arguments[1]);
        int threads = Integer.parseInt(arguments[2]);
        Jolt.registerDefaultAllocator();
        Jolt.newFactory();
        Jolt.registerTypes();
        TempAllocator memory = new TempAllocatorImpl(1600 << 20);
        JobSystem jobs =
                threads == 1
                        ? new JobSystemSingleThreaded(Jolt.cMaxPhysicsJobs)
                        : new JobSystemThreadPool(
                                Jolt.cMaxPhysicsJobs, Jolt.cMaxPhysicsBarriers, threads - 1);
        PhysicsSystem system = world(count);
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
                "{\"framesPerSecond\": %.3f, \"framesPerProcessorSecond\": %.3f}%n",
                FRAMES / wall, FRAMES / busy);
        System.exit(0);
    }

    private static long processorNanoseconds() {
        return ((OperatingSystemMXBean) ManagementFactory.getOperatingSystemMXBean())
                .getProcessCpuTime();
    }

    private static PhysicsSystem world(int count) {
        var system = new PhysicsSystem();
        system.init(
                count + 16,
                0,
                count * 8,
                count * 8,
                new MapObj2Bp(2, 2).add(MOVING, MOVING).add(FIXED, FIXED),
                new ObjVsBpFilter(2, 2).disablePair(FIXED, FIXED),
                new ObjVsObjFilter(2).disablePair(FIXED, FIXED));
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
        var ball = new SphereShape(0.5f);
        int side = Math.max(1, (int) Math.round(Math.sqrt(count / (double) LAYERS)));
        var random = new Random(1);
        for (int i = 0; i < count; i++) {
            var place =
                    new RVec3(
                            jittered(random, i % side),
                            0.6 + jittered(random, i / side / side),
                            jittered(random, i / side % side));
            var body =
                    new BodyCreationSettings(ball, place, new Quat(), EMotionType.Dynamic, MOVING);
            body.setAllowSleeping(false);
            body.setFriction(0.5f);
            bodies.createAndAddBody(body, EActivation.Activate);
        }
        system.optimizeBroadPhase();
        return system;
    }

    private static double jittered(Random random, int i) {
        return 1.1 * i + 0.1 * random.nextDouble() - 0.05;
    }
}
