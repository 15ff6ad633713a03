// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static reve.pe.vesper.VesperLayouts.PROPERTY;
import static reve.pe.vesper.VesperLayouts.offset;

import static java.lang.foreign.ValueLayout.ADDRESS;
import static java.lang.foreign.ValueLayout.JAVA_INT;
import static java.lang.foreign.ValueLayout.JAVA_LONG;

import org.jspecify.annotations.Nullable;

import reve.pe.PhysicalProperty;
import reve.pe.PhysicalPropertyProvider;
import reve.pe.PhysicsException;
import reve.pe.PropertyDescriptor;
import reve.pe.Prototype;
import reve.pe.ScalarType;
import reve.pe.Status;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.util.HashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Set;

/** The provider of one Vesper engine: passes the client's arrays to C. */
final class VesperProvider implements PhysicalPropertyProvider {
    private final VesperEngine engine;
    private final MemorySegment provider;
    private final VesperErrors errors;
    private final Map<String, Slot> slots = new HashMap<>();
    private final MemorySegment oneName;
    private final MemorySegment found;

    /**
     * Scopes of the bound arrays, without duplicates. This object checks that the scopes are alive
     * before C code accesses the arrays.
     */
    private MemorySegment.Scope[] lifetimes = {};

    private boolean lifetimesKnown = true;

    /** A property of the prototype: its name for C, and the bound arrays. */
    private static final class Slot {
        final PropertyDescriptor descriptor;
        final MemorySegment name;
        @Nullable MemorySegment data;
        @Nullable MemorySegment indices;

        Slot(PropertyDescriptor descriptor, MemorySegment name) {
            this.descriptor = descriptor;
            this.name = name;
        }
    }

    VesperProvider(
            VesperEngine engine,
            MemorySegment provider,
            VesperErrors errors,
            Prototype prototype,
            Arena arena) {
        this.engine = engine;
        this.provider = provider;
        this.errors = errors;
        for (PropertyDescriptor property : prototype.properties()) {
            slots.put(
                    property.name(),
                    new Slot(property, VesperStrings.write(arena, property.name())));
        }
        oneName = arena.allocate(ADDRESS);
        found = arena.allocate(PROPERTY);
    }

    @Override
    public void addPhysicalProperty(
            String name,
            MemorySegment data,
            long valueCount,
            @Nullable MemorySegment indices,
            long objectCount) {
        engine.checkOpen();
        Slot slot = slot(name);
        checkArrays(slot, data, valueCount, indices, objectCount);
        errors.check(
                EngineFunctions.providerAddPhysicalProperty(
                        provider,
                        slot.name,
                        data,
                        valueCount,
                        orNull(indices),
                        objectCount,
                        errors.segment()));
        lend(slot, data, indices);
    }

    @Override
    public void rebindPhysicalProperty(
            String name,
            MemorySegment data,
            long valueCount,
            @Nullable MemorySegment indices,
            long objectCount) {
        engine.checkOpen();
        Slot slot = slot(name);
        checkArrays(slot, data, valueCount, indices, objectCount);
        errors.check(
                EngineFunctions.providerRebindPhysicalProperty(
                        provider,
                        slot.name,
                        data,
                        valueCount,
                        orNull(indices),
                        objectCount,
                        errors.segment()));
        lend(slot, data, indices);
    }

    @Override
    public void removePhysicalProperty(String name) {
        engine.checkOpen();
        Slot slot = slot(name);
        errors.check(
                EngineFunctions.providerRemovePhysicalProperty(
                        provider, slot.name, errors.segment()));
        lend(slot, null, null);
    }

    @Override
    public PhysicalProperty findPhysicalProperty(String name) {
        engine.checkOpen();
        Slot slot = slot(name);
        found.set(JAVA_INT, offset(PROPERTY, "struct_size"), (int) PROPERTY.byteSize());
        errors.check(
                EngineFunctions.providerFindPhysicalProperty(
                        provider, slot.name, found, errors.segment()));
        return new PhysicalProperty(
                VesperStrings.readAt(found, offset(PROPERTY, "name")),
                VesperStrings.readAt(found, offset(PROPERTY, "kind")),
                VesperPrototypes.scalarType(found.get(JAVA_INT, offset(PROPERTY, "scalar_type"))),
                found.get(JAVA_INT, offset(PROPERTY, "components")),
                VesperPrototypes.access(found.get(JAVA_INT, offset(PROPERTY, "access"))),
                found.get(JAVA_LONG, offset(PROPERTY, "row_count")),
                found.get(JAVA_LONG, offset(PROPERTY, "version")));
    }

    @Override
    public void touch(String name) {
        engine.checkOpen();
        oneName.set(ADDRESS, 0, slot(name).name);
        errors.check(EngineFunctions.providerTouch(provider, oneName, 1, errors.segment()));
    }

    /** Throws an exception if the client has closed memory that the engine still uses. */
    void checkArraysAlive() {
        if (!lifetimesKnown) {
            collectLifetimes();
        }
        for (MemorySegment.Scope lifetime : lifetimes) {
            if (!lifetime.isAlive()) {
                throw new IllegalStateException(
                        "memory lent to the engine was closed;"
                                + " rebind or remove the property first: "
                                + dead());
            }
        }
    }

    private Slot slot(String name) {
        Slot slot = slots.get(name);
        if (slot == null) {
            throw new PhysicsException(
                    Status.NOT_FOUND,
                    0,
                    "",
                    "",
                    name,
                    -1,
                    "property '" + name + "' is not in the engine's prototype");
        }
        return slot;
    }

    /** Checks the bounds of arrays, because C receives only addresses. */
    private static void checkArrays(
            Slot slot,
            MemorySegment data,
            long valueCount,
            @Nullable MemorySegment indices,
            long objectCount) {
        PropertyDescriptor property = slot.descriptor;
        if (property.type() == ScalarType.FIELD) {
            return; // C refuses the call, so there are no arrays to check
        }
        checkArray(
                property.name(),
                "data",
                data,
                valueCount,
                (long) property.components() * property.type().bytes());
        if (indices != null) {
            checkArray(property.name(), "indices", indices, objectCount, Integer.BYTES);
        }
    }

    private static void checkArray(
            String property, String what, MemorySegment segment, long count, long bytesEach) {
        if (count < 0 || count > Long.MAX_VALUE / bytesEach) {
            throw new IllegalArgumentException(
                    property
                            + ": "
                            + what
                            + " has a count of "
                            + count
                            + ", expected 0 or more that fit into memory");
        }
        if (!segment.isNative()) {
            throw new IllegalArgumentException(
                    property + ": " + what + " is heap memory, expected native memory");
        }
        if (segment.byteSize() < count * bytesEach) {
            throw new IllegalArgumentException(
                    property
                            + ": "
                            + what
                            + " has "
                            + segment.byteSize()
                            + " bytes, expected at least "
                            + count * bytesEach
                            + " ("
                            + count
                            + " x "
                            + bytesEach
                            + ")");
        }
    }

    private void lend(Slot slot, @Nullable MemorySegment data, @Nullable MemorySegment indices) {
        slot.data = data;
        slot.indices = indices;
        lifetimesKnown = false;
    }

    private void collectLifetimes() {
        Set<MemorySegment.Scope> scopes = new LinkedHashSet<>();
        for (Slot slot : slots.values()) {
            if (slot.data != null) {
                scopes.add(slot.data.scope());
            }
            if (slot.indices != null) {
                scopes.add(slot.indices.scope());
            }
        }
        lifetimes = scopes.toArray(MemorySegment.Scope[]::new);
        lifetimesKnown = true;
    }

    private List<String> dead() {
        return slots.values().stream()
                .filter(slot -> isDead(slot.data) || isDead(slot.indices))
                .map(slot -> slot.descriptor.name())
                .sorted()
                .toList();
    }

    private static boolean isDead(@Nullable MemorySegment segment) {
        return segment != null && !segment.scope().isAlive();
    }

    private static MemorySegment orNull(@Nullable MemorySegment segment) {
        return segment == null ? MemorySegment.NULL : segment;
    }
}
