// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import org.jspecify.annotations.Nullable;

import java.lang.foreign.MemorySegment;

/**
 * Lends a client's arrays to an engine. Arrays are native memory and borrowed: they stay alive and
 * unmoved from add or rebind until remove, rebind or close of the engine. Same thread rule as the
 * engine. Every method throws {@link PhysicsException} for what the engine refuses.
 */
public interface PhysicalPropertyProvider {
    /**
     * Registers the array of a property of the prototype.
     *
     * @param data (valueCount x components) of the prototype's type, tightly packed
     * @param indices null: row i is value i and valueCount equals objectCount; else U32
     *     (objectCount): row i is value indices[i], and the property is read-only to laws
     * @throws IllegalArgumentException if a segment is not native or too small
     */
    void addPhysicalProperty(
            String name,
            MemorySegment data,
            long valueCount,
            @Nullable MemorySegment indices,
            long objectCount);

    /** Registers an array with one value per row. */
    default void addPhysicalProperty(String name, MemorySegment data, long objectCount) {
        addPhysicalProperty(name, data, objectCount, null, objectCount);
    }

    /**
     * The arrays grew, shrank or moved; arguments as for add. All properties of a kind must agree
     * on objectCount again by the next advance.
     */
    void rebindPhysicalProperty(
            String name,
            MemorySegment data,
            long valueCount,
            @Nullable MemorySegment indices,
            long objectCount);

    /** Rebinds an array with one value per row. */
    default void rebindPhysicalProperty(String name, MemorySegment data, long objectCount) {
        rebindPhysicalProperty(name, data, objectCount, null, objectCount);
    }

    /** Takes the array back; refused with ACCESS_CONFLICT while a loaded law needs it. */
    void removePhysicalProperty(String name);

    /** The property as it is bound. */
    PhysicalProperty findPhysicalProperty(String name);

    /**
     * Says that values were edited in place: references and least values are checked again, and
     * laws rebuild what they made of the values, such as a copy on a device. What is edited without
     * it may be overlooked.
     */
    void touch(String name);
}
