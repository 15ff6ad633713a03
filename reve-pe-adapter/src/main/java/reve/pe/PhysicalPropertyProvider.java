// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import org.jspecify.annotations.Nullable;

import java.lang.foreign.MemorySegment;

/**
 * The interface through which a client registers its arrays with an engine. Arrays are native
 * memory. The client must keep an array alive and in place until it removes or rebinds the property
 * or closes the engine. The thread rule of {@link PhysicsEngine} applies. Every method throws
 * {@link PhysicsException} if the engine refuses the call.
 */
public interface PhysicalPropertyProvider {
    /**
     * Registers the array of one of the prototype's properties.
     *
     * @param data (valueCount x components) of the prototype's type, tightly packed
     * @param indices null: row i is value i and valueCount equals objectCount. Otherwise U32
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
     * Replaces an array that grew, shrank or moved. The arguments are those of {@code
     * addPhysicalProperty}. All properties of a kind must have the same objectCount at the next
     * advance.
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

    /**
     * Removes an array. The engine refuses the call with ACCESS_CONFLICT while a loaded law needs
     * the array.
     */
    void removePhysicalProperty(String name);

    /** Returns the bound property. */
    PhysicalProperty findPhysicalProperty(String name);

    /**
     * Notifies the engine that values were edited in place. The engine checks references and
     * minimum values again, and laws update data derived from the values, such as a copy on a
     * device. The engine and the laws may otherwise continue to use old values.
     */
    void touch(String name);
}
