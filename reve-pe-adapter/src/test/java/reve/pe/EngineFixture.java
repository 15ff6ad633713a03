// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import reve.pe.vesper.VesperConfig;
import reve.pe.vesper.VesperEngine;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;

/** A validating engine for the spring orbit. It is made as a Java program without REVE makes it. */
public final class EngineFixture implements AutoCloseable {
    private final Home home;
    public final List<String> log = new ArrayList<>();
    public final PhysicsEngine engine;
    public final Map<String, MemorySegment> arrays = new HashMap<>();

    /** A kind of engine, and of the memory that can be lent to it. */
    public interface Home extends AutoCloseable {
        PhysicsEngine engine(VesperConfig config, Prototype prototype);

        /** Returns zeroed memory that lives until it is released, or this object is closed. */
        MemorySegment allocate(long bytes);

        void release(MemorySegment memory);

        @Override
        void close();
    }

    /** Engines of this process. */
    public static final class InProcess implements Home {
        private final Map<MemorySegment, Arena> arenas = new HashMap<>();

        @Override
        public PhysicsEngine engine(VesperConfig config, Prototype prototype) {
            return new VesperEngine(config, prototype);
        }

        @Override
        public MemorySegment allocate(long bytes) {
            Arena arena = Arena.ofShared();
            MemorySegment memory = arena.allocate(bytes, 64);
            arenas.put(memory, arena);
            return memory;
        }

        @Override
        public void release(MemorySegment memory) {
            arenas.remove(memory).close();
        }

        @Override
        public void close() {
            arenas.values().forEach(Arena::close);
        }
    }

    public EngineFixture(Home home) {
        this(home, VesperEngine.standardPrototype("si-f64"));
    }

    public EngineFixture(Home home, Prototype prototype) {
        this.home = home;
        engine =
                home.engine(
                        new VesperConfig(
                                1,
                                true,
                                NativeFiles.lawPath(),
                                (level, message) -> log.add(level + " " + message)),
                        prototype);
    }

    /** Returns memory that can be lent to the engine. */
    public MemorySegment allocate(long bytes) {
        return home.allocate(bytes);
    }

    public void release(MemorySegment memory) {
        home.release(memory);
    }

    /** Lends zeroed arrays for all properties: 2 bodies, 1 spring, no surface. */
    public EngineFixture lendAll() {
        for (PropertyDescriptor property : engine.prototype().properties()) {
            if (property.type() == ScalarType.FIELD) {
                continue;
            }
            long rows =
                    switch (property.kind()) {
                        case "body" -> 2;
                        case "surface" -> 0;
                        default -> 1;
                    };
            MemorySegment data =
                    allocate(Math.max(8, rows * property.components() * property.type().bytes()));
            arrays.put(property.name(), data);
            engine.propertyProvider().addPhysicalProperty(property.name(), data, rows);
        }
        return this;
    }

    /** Lends the arrays and fills them with the scene. */
    public EngineFixture springOrbit() {
        lendAll();
        set("mass", SpringOrbit.MASS);
        set("position", SpringOrbit.POSITION);
        set("velocity", SpringOrbit.VELOCITY);
        set("hookeConstant", SpringOrbit.HOOKE_CONSTANT);
        set("length", SpringOrbit.LENGTH);
        arrays.get("endpoints").setAtIndex(ValueLayout.JAVA_INT, 1, 1);
        engine.propertyProvider().touch("endpoints");
        return this;
    }

    public EngineFixture load(String... laws) {
        for (String law : laws) {
            engine.loadPhysicsLaw(law, Map.of());
        }
        return this;
    }

    public void set(String property, double... values) {
        MemorySegment.copy(
                values, 0, arrays.get(property), ValueLayout.JAVA_DOUBLE, 0, values.length);
    }

    public double[] get(String property) {
        return arrays.get(property).toArray(ValueLayout.JAVA_DOUBLE);
    }

    @Override
    public void close() {
        engine.close();
        home.close();
    }
}
