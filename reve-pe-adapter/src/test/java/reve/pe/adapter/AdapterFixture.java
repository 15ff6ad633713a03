// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.frame.CommandQueue;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.world.Column;
import reve.core.world.ColumnArena;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;
import reve.pe.NativeFiles;
import reve.pe.PhysicsEngine;
import reve.pe.SpringOrbit;
import reve.pe.vesper.VesperConfig;
import reve.pe.vesper.VesperEngine;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.function.UnaryOperator;

/**
 * A world, its adapter and an engine. The test makes each frame. There are 60 frames/s with 4 steps
 * each.
 */
final class AdapterFixture implements AutoCloseable {
    static final int FRAMES = SpringOrbit.STEPS / 4;

    final ColumnArena arena;
    final World world;
    final PhysicsEngine engine;
    final FrameBus bus = new FrameBus();
    final CommandQueue commands = new CommandQueue(1000);

    /** Events of all frames so far. */
    final List<WorldEvent> events = new ArrayList<>();

    final FrameLoop loop;
    final PhysicsAdapter adapter;

    /** An empty world of the standard prototype. */
    AdapterFixture() {
        this(
                WorldPrototype.standard("si-f64"),
                List.of(),
                new OffHeapArena(),
                true,
                engine -> engine);
    }

    /**
     * @param validate whether laws run on guarded copies or on the columns themselves
     * @param engine the engine that the adapter uses
     */
    AdapterFixture(
            WorldPrototype prototype,
            List<ItemDefinition> items,
            ColumnArena arena,
            boolean validate,
            UnaryOperator<PhysicsEngine> engine) {
        this.arena = arena;
        this.world = new World("test", prototype, arena);
        world.addAll(items);
        this.engine =
                engine.apply(
                        new VesperEngine(
                                new VesperConfig(
                                        1, validate, NativeFiles.lawPath(), (level, message) -> {}),
                                PropertyNames.prototype(
                                        prototype,
                                        VesperEngine.standardPrototype(prototype.name()))));
        this.adapter = new PhysicsAdapter(world, this.engine, arena);
        commands.subscribeTo(bus);
        bus.subscribe(FramePhase.PHYSICS, "physics", adapter);
        bus.subscribe(
                FramePhase.PUBLISH,
                "events",
                frame -> {
                    if (!world.events().isEmpty()) {
                        events.addAll(world.events());
                    }
                });
        this.loop = new FrameLoop(world, bus, new Timing(60, 4), Pacing.FAST);
    }

    /** The scene of {@link SpringOrbit} with its laws. */
    static AdapterFixture springOrbit() {
        return springOrbit(true);
    }

    static AdapterFixture springOrbit(boolean validate) {
        return springOrbitWithoutLaws(validate).load(SpringOrbit.LAWS);
    }

    static AdapterFixture springOrbitWithoutLaws(boolean validate) {
        return new AdapterFixture(
                WorldPrototype.standard("si-f64"),
                springOrbitItems(),
                new OffHeapArena(),
                validate,
                engine -> engine);
    }

    static List<ItemDefinition> springOrbitItems() {
        return List.of(
                body("red", SpringOrbit.MASS[0], -10, 5, 0, 0, 3, 0),
                body("blue", SpringOrbit.MASS[1], 10, 5, 0, 0, 0, 0),
                ItemDefinition.named("band")
                        .kind("spring")
                        .physics("springConstant", SpringOrbit.HOOKE_CONSTANT)
                        .physics("length", SpringOrbit.LENGTH)
                        .reference("end1", "red")
                        .reference("end2", "blue")
                        .build());
    }

    /** Returns a body with a mass [kg], a location [m] and a velocity [m/s]. */
    static ItemDefinition body(
            String name,
            double mass,
            double x,
            double y,
            double z,
            double vx,
            double vy,
            double vz) {
        return ItemDefinition.named(name)
                .at(x, y, z)
                .physics("mass", mass)
                .physics("velocity", vx, vy, vz)
                .build();
    }

    AdapterFixture load(String... laws) {
        for (String law : laws) {
            adapter.laws().load(0, law, Map.of());
        }
        return this;
    }

    AdapterFixture run(int frames) {
        for (int i = 0; i < frames; i++) {
            loop.step();
        }
        return this;
    }

    double[] velocity(String item) {
        return world.find(item).orElseThrow().physics().vector("velocity");
    }

    /** Returns the bits of the numbers that move: position and velocity of an item. */
    List<Long> motion(String item) {
        Table bodies = world.table("body");
        int row = bodies.rowOf(world.find(item).orElseThrow().id());
        List<Long> bits = new ArrayList<>();
        for (Column column : List.of(bodies.column("position"), bodies.column("velocity"))) {
            for (int i = 0; i < 3; i++) {
                bits.add(Double.doubleToRawLongBits(column.getDouble(row, i)));
            }
        }
        return bits;
    }

    /** Returns all bytes of all columns, by kind and property. */
    Map<String, List<Byte>> bytes() {
        Map<String, List<Byte>> bytes = new LinkedHashMap<>();
        for (Table table : world.tables()) {
            for (Column column : table.columns()) {
                MemorySegment segment = column.segment();
                List<Byte> copy = new ArrayList<>();
                for (byte b : segment.toArray(ValueLayout.JAVA_BYTE)) {
                    copy.add(b);
                }
                bytes.put(table.kind() + "." + column.name(), copy);
            }
        }
        return bytes;
    }

    List<WorldEvent> events(String type) {
        return events.stream().filter(event -> event.type().equals(type)).toList();
    }

    @Override
    public void close() {
        engine.close();
        adapter.close();
        arena.close();
    }
}
