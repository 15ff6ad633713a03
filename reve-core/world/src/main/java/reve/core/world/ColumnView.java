// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.unit.Unit;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.Objects;

/**
 * One property of all items of a kind as a packed array of shape (rows x components), in native
 * byte order. The array belongs to a live world ({@link Column}) or to a snapshot ({@link
 * ColumnSnapshot}). Every access checks row and component. Loops over many rows use {@link
 * #segment()}, which avoids these checks.
 */
public abstract sealed class ColumnView permits Column, ColumnSnapshot {

    static final ValueLayout.OfFloat FLOAT = ValueLayout.JAVA_FLOAT;
    static final ValueLayout.OfDouble DOUBLE = ValueLayout.JAVA_DOUBLE;
    static final ValueLayout.OfInt INT = ValueLayout.JAVA_INT;
    static final ValueLayout.OfLong LONG = ValueLayout.JAVA_LONG;

    private final PropertyDescriptor descriptor;

    ColumnView(PropertyDescriptor descriptor) {
        this.descriptor = descriptor;
    }

    /** Returns the property of this column. */
    public final PropertyDescriptor descriptor() {
        return descriptor;
    }

    /** Returns the name of the property. */
    public final String name() {
        return descriptor.name();
    }

    /** Returns the element type. */
    public final ScalarType type() {
        return descriptor.type();
    }

    /** Returns the number of components per row. */
    public final int components() {
        return descriptor.components();
    }

    /** Returns the unit of every number. */
    public final Unit unit() {
        return descriptor.unit();
    }

    /** Returns the number of used rows. */
    public abstract int rowCount();

    /**
     * Returns the memory of the used rows. The caller must call this method again whenever {@link
     * World#layoutVersion()} has changed.
     */
    public abstract MemorySegment segment();

    /** Returns {@link #segment()} as a direct buffer in native byte order. */
    public final ByteBuffer buffer() {
        return segment().asByteBuffer().order(ByteOrder.nativeOrder());
    }

    /** Returns one number of any type except REF. The result for a U32 is 0 to 2^32 - 1. */
    public final double getDouble(int row, int component) {
        long offset = offset(row, component);
        return switch (type()) {
            case F64 -> memory().get(DOUBLE, offset);
            case F32 -> memory().get(FLOAT, offset);
            case I32 -> memory().get(INT, offset);
            case U32 -> Integer.toUnsignedLong(memory().get(INT, offset));
            case REF -> throw wrongType("a number");
        };
    }

    /** Returns one number of type I32, or the 32 bits of a U32. */
    public final int getInt(int row, int component) {
        long offset = offset(row, component);
        return switch (type()) {
            case I32, U32 -> memory().get(INT, offset);
            case F64, F32, REF -> throw wrongType("an integer");
        };
    }

    /** Returns one number of type REF: the value of an {@link ItemId}, 0 for none. */
    public final long getReference(int row, int component) {
        if (type() != ScalarType.REF) {
            throw wrongType("a reference");
        }
        return memory().get(LONG, offset(row, component));
    }

    /** Returns the memory, which may contain more than {@link #rowCount()} rows. */
    abstract MemorySegment memory();

    final long offset(int row, int component) {
        Objects.checkIndex(row, rowCount());
        Objects.checkIndex(component, components());
        return ((long) row * components() + component) * type().bytes();
    }

    final IllegalStateException wrongType(String wanted) {
        return new IllegalStateException(
                "property " + name() + " holds " + type() + ", not " + wanted);
    }

    @Override
    public final String toString() {
        return descriptor.kind()
                + "."
                + name()
                + " "
                + type()
                + "x"
                + components()
                + " ["
                + unit().symbol()
                + "], "
                + rowCount()
                + " rows";
    }
}
