// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import org.jspecify.annotations.Nullable;

import reve.core.unit.Unit;
import reve.core.world.FieldDescriptor;
import reve.core.world.WorldPrototype;
import reve.pe.Access;
import reve.pe.PropertyDescriptor;
import reve.pe.Prototype;
import reve.pe.ScalarType;
import reve.pe.SiUnit;

import java.util.ArrayList;
import java.util.EnumSet;
import java.util.HashSet;
import java.util.List;
import java.util.Optional;
import java.util.Set;
import java.util.stream.Stream;

/**
 * Translation of REVE's property names to the names of an engine. The names are equal, except for
 * the names in a table of this class.
 */
public final class PropertyNames {
    /** The engine's kind for the rows of bodies without a physics aspect. */
    static final String SCENERY = "scenery";

    private static final List<Translation> TABLE =
            List.of(
                    new Translation("spring", "hookeConstant", List.of("springConstant")),
                    new Translation("spring", "endpoints", List.of("end1", "end2")),
                    new Translation(SCENERY, "sceneryPosition", List.of("position")),
                    new Translation(SCENERY, "sceneryOrientation", List.of("orientation")),
                    new Translation(SCENERY, "sceneryShape", List.of("shape")),
                    new Translation(SCENERY, "scenerySize", List.of(PropertyNames.SIZE)));

    /** Properties that the adapter computes from the attachments of items. */
    private static final Set<String> CARRIERS = Set.of("carrier", "sceneryCarrier");

    /** Properties that refer to rows of {@link #MESH_FORM}. */
    private static final Set<String> MESHES = Set.of("meshForm", "sceneryMeshForm");

    /** The engine's kinds for the meshes of all items, their points and their numbers of points. */
    static final String MESH_FORM = "meshForm";

    static final String MESH_POINT = "meshPoint";
    static final String MESH_INDEX = "meshNumber";
    private static final Set<String> MESH_KINDS = Set.of(MESH_FORM, MESH_POINT, MESH_INDEX);

    /** The extents of the shapes of bodies, along the axes of each body. */
    static final String SIZE = "size";

    /** Properties of bodies that an engine receives only while a law uses them. */
    private static final Set<String> ON_DEMAND = Set.of("shape", SIZE, "carrier", "meshForm");

    /**
     * The engine's name of a property, and REVE's columns for it.
     *
     * @param columns REVE's columns, side by side in the engine's property
     */
    private record Translation(String kind, String engineName, List<String> columns) {}

    private PropertyNames() {}

    /**
     * Returns the prototype for an engine: the properties of the world's items, in REVE's types and
     * units, and fields, for which items have no values.
     *
     * @param standard the engine's standard prototype, which limits the access of laws to standard
     *     properties. Laws may read and write the properties that designers add. References are
     *     only read, and laws add to accumulated properties
     */
    public static Prototype prototype(WorldPrototype world, Prototype standard) {
        List<PropertyDescriptor> properties = new ArrayList<>();
        Set<String> standardColumns = new HashSet<>();
        for (PropertyDescriptor property : standard.properties()) {
            if (property.type() == ScalarType.FIELD) {
                properties.add(property);
                continue;
            }
            if (isTaken(world, property)) {
                continue;
            }
            if (isCarrier(property) || isOfMeshes(property)) {
                properties.add(property);
                continue;
            }
            List<reve.core.world.PropertyDescriptor> found =
                    find(world, table(property.kind()), columns(property.kind(), property.name()));
            if (!found.isEmpty()) {
                properties.add(
                        translated(
                                property.name(),
                                property.kind(),
                                found,
                                property.lawAccess(),
                                property.initialFrom()));
                found.forEach(column -> standardColumns.add(column.name()));
            }
        }
        for (reve.core.world.PropertyDescriptor own : world.properties()) {
            if (!standardColumns.contains(own.name())) {
                properties.add(
                        translated(
                                own.name(), own.kind(), List.of(own), designersAccess(own), null));
            }
        }
        for (FieldDescriptor field : world.fields()) {
            properties.add(
                    new PropertyDescriptor(
                            field.name(),
                            WorldPrototype.WORLD,
                            ScalarType.FIELD,
                            field.components(),
                            EnumSet.of(Access.READ),
                            unit(field.unit()),
                            null,
                            null,
                            field.doc()));
        }
        return new Prototype(
                standard.name(), scalarType(world.realType()), standard.timeUnit(), properties);
    }

    /**
     * Returns whether a property contains, for each attached item, the row of the body that carries
     * the item.
     */
    static boolean isCarrier(PropertyDescriptor property) {
        return CARRIERS.contains(property.name());
    }

    /** Returns whether a property contains, for items with a mesh, the row of the mesh. */
    static boolean isMesh(PropertyDescriptor property) {
        return MESHES.contains(property.name());
    }

    /** Returns whether the adapter computes a property from the meshes of items. */
    static boolean isOfMeshes(PropertyDescriptor property) {
        return isMesh(property) || MESH_KINDS.contains(property.kind());
    }

    /** Returns whether the engine receives the property only while a law uses it. */
    static boolean isOnDemand(PropertyDescriptor property) {
        return property.kind().equals(SCENERY)
                || MESH_KINDS.contains(property.kind())
                || property.kind().equals(WorldPrototype.BODY)
                        && ON_DEMAND.contains(property.name());
    }

    /** Returns the table of REVE whose rows are those of an engine's kind. */
    static String table(String kind) {
        return kind.equals(SCENERY) || MESH_KINDS.contains(kind) ? WorldPrototype.BODY : kind;
    }

    /**
     * Returns whether the world contains a kind or property that has the same name as a property of
     * the adapter, because a designer added it.
     */
    private static boolean isTaken(WorldPrototype world, PropertyDescriptor property) {
        return isOnDemand(property)
                        && !property.kind().equals(WorldPrototype.BODY)
                        && world.kinds().contains(property.kind())
                || isOnDemand(property)
                        && world.properties().stream()
                                .anyMatch(own -> own.name().equals(property.name()));
    }

    /** Returns the names of REVE's columns that form an engine's property, side by side. */
    public static List<String> columns(String kind, String engineName) {
        return TABLE.stream()
                .filter(row -> row.kind.equals(kind) && row.engineName.equals(engineName))
                .findFirst()
                .map(Translation::columns)
                .orElse(List.of(engineName));
    }

    /** Returns the columns with these names, or an empty list if the world lacks one of them. */
    private static List<reve.core.world.PropertyDescriptor> find(
            WorldPrototype world, String kind, List<String> columns) {
        List<reve.core.world.PropertyDescriptor> found =
                columns.stream()
                        .map(column -> find(world, kind, column))
                        .flatMap(Optional::stream)
                        .toList();
        return found.size() == columns.size() ? found : List.of();
    }

    private static Optional<reve.core.world.PropertyDescriptor> find(
            WorldPrototype world, String kind, String column) {
        return Stream.concat(world.physicalProperties().stream(), world.properties().stream())
                .filter(property -> property.kind().equals(kind) && property.name().equals(column))
                .findFirst();
    }

    private static PropertyDescriptor translated(
            String name,
            String kind,
            List<reve.core.world.PropertyDescriptor> columns,
            Set<Access> access,
            @Nullable String initialFrom) {
        reve.core.world.PropertyDescriptor first = columns.getFirst();
        int components =
                columns.stream().mapToInt(reve.core.world.PropertyDescriptor::components).sum();
        ScalarType type = scalarType(first.type());
        boolean real = type == ScalarType.F32 || type == ScalarType.F64;
        // The sizes of scenery are those of shapes, which no law writes.
        double minimum =
                real && !access.contains(Access.ACCUMULATE) && !kind.equals(SCENERY)
                        ? first.minimum()
                        : Double.NEGATIVE_INFINITY;
        return new PropertyDescriptor(
                name,
                kind,
                type,
                components,
                access,
                unit(first.unit()),
                first.refersTo().orElse(null),
                initialFrom,
                minimum,
                first.doc());
    }

    private static Set<Access> designersAccess(reve.core.world.PropertyDescriptor property) {
        if (property.refersTo().isPresent()) {
            return EnumSet.of(Access.READ);
        }
        return EnumSet.of(Access.READ, property.accumulated() ? Access.ACCUMULATE : Access.WRITE);
    }

    private static ScalarType scalarType(reve.core.world.ScalarType type) {
        return switch (type) {
            case F32 -> ScalarType.F32;
            case F64 -> ScalarType.F64;
            case I32 -> ScalarType.I32;
            case U32, REF -> ScalarType.U32; // a reference is a row number for laws
        };
    }

    private static SiUnit unit(Unit unit) {
        return SiUnit.of(unit.exponents(), unit.scale(), unit.symbol());
    }
}
