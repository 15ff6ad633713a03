// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import org.jspecify.annotations.Nullable;

import reve.core.mesh.MassProperties;
import reve.core.world.Item;
import reve.core.world.Mesh;
import reve.core.world.PropertyDescriptor;
import reve.core.world.Relations;
import reve.core.world.Shape;
import reve.core.world.WorldPrototype;

import java.util.AbstractMap;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.Function;
import java.util.function.LongConsumer;
import java.util.function.Supplier;

/**
 * The names by which expressions read an item. Each aspect is a map that reads a value of the item
 * when the value is accessed.
 */
final class ItemNames {
    private static final String SYMBOL = KindNames.SEMANTIC + ".";

    /** Number of corners of triangles that the computation of a volume visits for one step. */
    private static final int INDICES_PER_STEP = 24;

    private final KindNames kind;
    private final LongConsumer steps;
    private @Nullable Item item;
    private final Map<String, Object> physics;
    private final Map<String, Object> physical;
    private final Map<String, Object> semantic;
    private final Map<String, Object> self;

    /**
     * Cache of the item's relations. It saves time because a loop may read a relation in every
     * iteration.
     */
    private final Map<String, Optional<Object>> relations = new HashMap<>();

    /**
     * @param steps receives the number of steps of each computation of relations
     */
    ItemNames(KindNames kind, LongConsumer steps) {
        this.kind = kind;
        this.steps = steps;
        physics = new View(this::physicsNames, this::physics);
        physical = new View(() -> kind.physicalNames().keySet(), this::physical);
        semantic = new View(() -> required().semantic().symbols().keySet(), this::semantic);
        self = new View(() -> KindNames.ITEM_NAMES, this::self);
    }

    void of(Item newItem) {
        item = newItem;
        relations.clear();
    }

    /**
     * Returns the value of {@code item}, of an aspect, or of a declared symbol by its full name,
     * for example {@code semantic.lit}. Returns null for other names.
     */
    @Nullable Object find(String name) {
        if (name.startsWith(SYMBOL)) {
            return semantic(name.substring(SYMBOL.length()));
        }
        return switch (name) {
            case KindNames.PHYSICS -> physics;
            case KindNames.PHYSICAL -> physical;
            case KindNames.SEMANTIC -> semantic;
            case KindNames.SELF -> self;
            default -> null;
        };
    }

    /** Returns all aspects by name, and the other names of {@code item}. */
    Map<String, Object> asMap() {
        Map<String, Object> map = new LinkedHashMap<>();
        map.put(KindNames.PHYSICS, physics);
        map.put(KindNames.PHYSICAL, physical);
        map.put(KindNames.SEMANTIC, semantic);
        self.forEach(map::put);
        return map;
    }

    private Item required() {
        Item present = item;
        if (present == null) {
            throw new IllegalStateException("no item was given to evaluate for");
        }
        return present;
    }

    private Set<String> physicsNames() {
        return required().physics().isEmpty() ? Set.of() : kind.physicsNames();
    }

    private @Nullable Object physics(String name) {
        PropertyDescriptor property = kind.property(name);
        if (property == null || required().physics().isEmpty()) {
            return null;
        }
        double scale = property.unit().scale();
        if (property.components() == 1) {
            return required().physics().scalar(name) * scale;
        }
        return list(required().physics().vector(name), scale);
    }

    private @Nullable Object physical(String name) {
        if (!kind.physicalNames().containsKey(name)) {
            return null;
        }
        return switch (name) {
            case "location" -> list(required().physical().location(), 1);
            case "orientation" -> list(required().physical().orientation(), 1);
            case "size" -> list(required().physical().size(), 1);
            case KindNames.VOLUME -> volume(required().physical().shape());
            case KindNames.MOVABLE -> isMovable(required());
            case KindNames.SUBSTANCE -> required().physics().substance().orElse("");
            default -> required().physical().colour().toString();
        };
    }

    /**
     * Returns the volume of a shape [m^3], 0 if it encloses none. Counts steps for the triangles of
     * a mesh.
     */
    private double volume(Shape shape) {
        if (shape instanceof Mesh mesh) {
            steps.accept(mesh.triangles().remaining() / INDICES_PER_STEP);
        }
        try {
            return MassProperties.of(shape, 1).volume();
        } catch (IllegalArgumentException enclosesNone) {
            return 0;
        }
    }

    private static boolean isMovable(Item item) {
        return !item.physics().isEmpty() && item.physics().scalar(WorldPrototype.MASS) > 0;
    }

    private @Nullable Object semantic(String name) {
        Item present = required();
        Object value =
                (Relations.NAMES.contains(name)
                                ? relations.computeIfAbsent(
                                        name, relation -> related(present, relation))
                                : present.semantic().get(name))
                        .orElse(null);
        return value instanceof Double number ? kind.toSi(name, number) : value;
    }

    /**
     * Computes a spatial relation. Counts one step for each compared body and for each name found.
     */
    private Optional<Object> related(Item present, String relation) {
        Relations all = present.semantic().relations();
        long before = all.compared();
        Optional<List<String>> names = all.of(present.id(), relation);
        steps.accept(all.compared() - before + names.map(List::size).orElse(0));
        return names.map(list -> list);
    }

    private @Nullable Object self(String name) {
        return switch (name) {
            case "name" -> required().name();
            case "kind" -> required().kind();
            default -> null;
        };
    }

    private static List<Double> list(double[] numbers, double scale) {
        List<Double> list = new ArrayList<>(numbers.length);
        for (double number : numbers) {
            list.add(number * scale);
        }
        return list;
    }

    /**
     * A read-only map whose values are computed when they are accessed. CEL normally reads single
     * names. Only its macros iterate over the map.
     */
    static final class View extends AbstractMap<String, Object> {
        private final Supplier<Set<String>> names;
        private final Function<String, @Nullable Object> values;

        View(Supplier<Set<String>> names, Function<String, @Nullable Object> values) {
            this.names = names;
            this.values = values;
        }

        @Override
        public @Nullable Object get(@Nullable Object key) {
            return key instanceof String name ? values.apply(name) : null;
        }

        @Override
        public boolean containsKey(@Nullable Object key) {
            return get(key) != null;
        }

        @Override
        public int size() {
            return names.get().size();
        }

        @Override
        public Set<Entry<String, Object>> entrySet() {
            Map<String, Object> all = new LinkedHashMap<>();
            for (String name : names.get()) {
                Object value = values.apply(name);
                if (value != null) {
                    all.put(name, value);
                }
            }
            return all.entrySet();
        }
    }
}
