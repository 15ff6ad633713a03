// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import reve.pe.NativeFiles;
import reve.pe.PropertyDescriptor;
import reve.pe.Prototype;
import reve.pe.ScalarType;
import reve.pe.SpringOrbit;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;

/** A validating engine for the spring orbit, as a Java program without REVE creates it. */
final class EngineFixture implements AutoCloseable {
    final Arena arena = Arena.ofShared();
    final List<String> log = new ArrayList<>();
    final VesperEngine engine;
    final Map<String, MemorySegment> arrays = new HashMap<>();

    EngineFixture() {
        this(VesperEngine.standardPrototype("si-f64"));
    }

    EngineFixture(Prototype prototype) {
        engine =
                new VesperEngine(
                        new VesperConfig(
                                1,
                                true,
                                NativeFiles.lawPath(),
                                (level, message) -> log.add(level + " " + message)),
                        prototype);
    }

    /** Lends zeroed arrays for all properties: 2 bodies, 1 spring, no surface. */
    EngineFixture lendAll() {
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
                    arena.allocate(rows * property.components() * property.type().bytes(), 64);
            arrays.put(property.name(), data);
            engine.propertyProvider().addPhysicalProperty(property.name(), data, rows);
        }
        return this;
    }

    /** Lends the arrays and fills them with the scene. */
    EngineFixture springOrbit() {
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

    EngineFixture load(String... laws) {
        for (String law : laws) {
            engine.loadPhysicsLaw(law, Map.of());
        }
        return this;
    }

    void set(String property, double... values) {
        MemorySegment.copy(
                values, 0, arrays.get(property), ValueLayout.JAVA_DOUBLE, 0, values.length);
    }

    double[] get(String property) {
        return arrays.get(property).toArray(ValueLayout.JAVA_DOUBLE);
    }

    @Override
    public void close() {
        engine.close();
        arena.close();
    }
}
