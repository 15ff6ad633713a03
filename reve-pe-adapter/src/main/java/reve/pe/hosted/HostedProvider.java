// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import org.jspecify.annotations.Nullable;

import reve.pe.Access;
import reve.pe.PhysicalProperty;
import reve.pe.PhysicalPropertyProvider;
import reve.pe.PhysicsException;
import reve.pe.PropertyDescriptor;
import reve.pe.Prototype;
import reve.pe.ScalarType;
import reve.pe.Status;
import reve.pe.posix.SharedPart;

import java.lang.foreign.MemorySegment;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Set;
import java.util.function.Function;

/**
 * The provider of a hosted engine. It keeps the client's arrays, which each host (engine process)
 * maps. It sends all rebound arrays to the host together with the next call of the engine. That
 * call fails if the host refuses their values.
 */
final class HostedProvider implements PhysicalPropertyProvider {
    private static final int NO_DESCRIPTOR = -1;

    private final HostedEngine engine;
    private final Function<MemorySegment, SharedPart> parts;
    private final Map<String, PropertyDescriptor> properties = new LinkedHashMap<>();
    private final Map<String, Arrays> bound = new LinkedHashMap<>();

    /**
     * Properties whose values the client has edited. The next call reports these properties to the
     * host.
     */
    private final Set<String> touched = new LinkedHashSet<>();

    /** The properties whose arrays the current host (engine process) has received. */
    private final Set<String> lent = new HashSet<>();

    /**
     * Properties that were rebound since the last call. The next call sends their arrays to the
     * host.
     */
    private final Set<String> pending = new LinkedHashSet<>();

    /**
     * Maximum number of rows so far, by kind. Laws may need time to build larger data structures if
     * this number grows.
     */
    private final Map<String, Long> mostRows = new HashMap<>();

    private MemorySegment.Scope[] lifetimes = {};
    private boolean lifetimesKnown = true;

    /** The bound arrays of a property. */
    private record Arrays(
            MemorySegment data,
            long valueCount,
            @Nullable MemorySegment indices,
            long objectCount) {}

    HostedProvider(
            HostedEngine engine, Prototype prototype, Function<MemorySegment, SharedPart> parts) {
        this.engine = engine;
        this.parts = parts;
        prototype.properties().forEach(property -> properties.put(property.name(), property));
    }

    @Override
    public void addPhysicalProperty(
            String name,
            MemorySegment data,
            long valueCount,
            @Nullable MemorySegment indices,
            long objectCount) {
        bind(Request.ADD, name, new Arrays(data, valueCount, indices, objectCount));
    }

    @Override
    public void rebindPhysicalProperty(
            String name,
            MemorySegment data,
            long valueCount,
            @Nullable MemorySegment indices,
            long objectCount) {
        bind(Request.REBIND, name, new Arrays(data, valueCount, indices, objectCount));
    }

    private void bind(Request request, String name, Arrays arrays) {
        PropertyDescriptor property = require(name);
        if (property.type() != ScalarType.FIELD) {
            checkArray(
                    name,
                    "data",
                    arrays.data,
                    arrays.valueCount,
                    (long) property.components() * property.type().bytes());
            if (arrays.indices != null) {
                checkArray(name, "indices", arrays.indices, arrays.objectCount, Integer.BYTES);
            }
        }
        if (request == Request.REBIND && bound.containsKey(name) && arrays.indices == null) {
            pending.add(name);
        } else {
            engine.ask(host -> put(host.begin(request), name, arrays));
            pending.remove(name);
            lent.add(name);
        }
        touched.remove(name);
        bound.put(name, arrays);
        lifetimesKnown = false;
        if (arrays.objectCount > mostRows.getOrDefault(property.kind(), 0L)) {
            mostRows.put(property.kind(), arrays.objectCount);
            engine.expectBuilding();
        }
    }

    /** Returns whether there are rebound arrays that the host does not have yet. */
    boolean hasPending() {
        return !pending.isEmpty();
    }

    /** Sends all rebound arrays to the host in one request. */
    void flush(Calls host) throws HostLost {
        List<String> names =
                pending.stream()
                        .filter(name -> !isDead(Objects.requireNonNull(bound.get(name))))
                        .toList();
        if (names.isEmpty()) {
            return;
        }
        try {
            host.call(
                    to -> {
                        Mailbox request = to.begin(Request.BIND_ALL).putInt(names.size());
                        for (String name : names) {
                            request.putInt(lent.contains(name) ? 1 : 0);
                            put(request, name, Objects.requireNonNull(bound.get(name)));
                        }
                    });
        } catch (PhysicsException refused) {
            // The host may have received only some of the arrays. The next host gets all of them.
            engine.lose();
            throw refused;
        }
        lent.addAll(names);
        names.forEach(pending::remove);
    }

    private void put(Mailbox to, String name, Arrays arrays) {
        to.putText(name);
        put(to, arrays.data);
        to.putLong(arrays.valueCount);
        put(to, arrays.indices);
        to.putLong(arrays.objectCount);
    }

    private void put(Mailbox to, @Nullable MemorySegment memory) {
        if (memory == null || memory.byteSize() == 0) {
            to.putInt(NO_DESCRIPTOR).putLong(0).putLong(0);
        } else {
            SharedPart part = parts.apply(memory);
            to.putInt(part.descriptor()).putLong(part.offset()).putLong(memory.byteSize());
        }
    }

    @Override
    public void removePhysicalProperty(String name) {
        require(name);
        engine.ask(host -> host.begin(Request.REMOVE).putText(name));
        touched.remove(name);
        lent.remove(name);
        pending.remove(name);
        bound.remove(name);
        lifetimesKnown = false;
    }

    @Override
    public PhysicalProperty findPhysicalProperty(String name) {
        PropertyDescriptor property = require(name);
        flushTouches();
        Mailbox found = engine.ask(host -> host.begin(Request.FIND).putText(name));
        return new PhysicalProperty(
                name,
                property.kind(),
                property.type(),
                property.components(),
                property.lawAccess(),
                found.getLong(),
                found.getLong());
    }

    @Override
    public void touch(String name) {
        PropertyDescriptor property = require(name);
        touched.add(name);
        if (!bound.containsKey(name)
                || property.refersTo() != null
                || property.minimum() != Double.NEGATIVE_INFINITY
                        && !property.lawAccess().contains(Access.WRITE)) {
            flushTouches(); // the engine may refuse the values in this request
        }
    }

    /** Sends the names of the properties with edited values to the host. */
    void flushTouches() {
        if (!touched.isEmpty()) {
            try {
                engine.ask(this::putTouched);
            } finally {
                touched.clear();
            }
        }
    }

    private void putTouched(HostProcess host) {
        Mailbox request = host.begin(Request.TOUCH).putInt(touched.size());
        touched.forEach(request::putText);
    }

    /** Sends all bound arrays to a new host, which has none yet. */
    void bindAll(Calls host) throws HostLost {
        lent.clear();
        pending.addAll(bound.keySet());
        flush(host);
        touched.clear();
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
                                + bound.entrySet().stream()
                                        .filter(entry -> isDead(entry.getValue()))
                                        .map(Map.Entry::getKey)
                                        .sorted()
                                        .toList());
            }
        }
    }

    private static boolean isDead(Arrays arrays) {
        return !arrays.data.scope().isAlive()
                || arrays.indices != null && !arrays.indices.scope().isAlive();
    }

    private void collectLifetimes() {
        Set<MemorySegment.Scope> scopes = new LinkedHashSet<>();
        for (Arrays arrays : bound.values()) {
            scopes.add(arrays.data.scope());
            if (arrays.indices != null) {
                scopes.add(arrays.indices.scope());
            }
        }
        lifetimes = scopes.toArray(MemorySegment.Scope[]::new);
        lifetimesKnown = true;
    }

    /** Returns the row of an offset [bytes] in the column of a property, or -1 if there is none. */
    long row(String name, long offset) {
        PropertyDescriptor property = properties.get(name);
        Arrays arrays = bound.get(name);
        if (property == null || arrays == null || property.type() == ScalarType.FIELD) {
            return -1;
        }
        long row = offset / ((long) property.components() * property.type().bytes());
        return row >= 0 && row < arrays.objectCount ? row : -1;
    }

    private PropertyDescriptor require(String name) {
        engine.checkOpen();
        PropertyDescriptor property = properties.get(name);
        if (property == null) {
            throw new PhysicsException(
                    Status.NOT_FOUND,
                    0,
                    "",
                    "",
                    name,
                    -1,
                    "property '" + name + "' is not in the engine's prototype");
        }
        return property;
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
}
