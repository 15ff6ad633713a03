// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import org.jspecify.annotations.Nullable;

import reve.pe.PreparedLibrary;

import java.lang.foreign.MemorySegment;

/** A {@code vesper_prepared_library} that no engine has taken yet. */
final class VesperPreparedLibrary implements PreparedLibrary {
    private final String name;
    private final String sha256;
    private final byte[] bytes;
    private final @Nullable String source;
    private @Nullable MemorySegment prepared;

    /**
     * @param source name of a text for messages; null for a compiled library
     */
    VesperPreparedLibrary(MemorySegment prepared, byte[] bytes, @Nullable String source) {
        this.prepared = prepared;
        this.source = source;
        this.name = VesperStrings.read(LibraryFunctions.libraryName(prepared));
        this.sha256 = LibraryFile.sha256(bytes);
        this.bytes = bytes;
    }

    @Override
    public String name() {
        return name;
    }

    @Override
    public String sha256() {
        return sha256;
    }

    @Override
    public byte[] bytes() {
        return bytes;
    }

    @Override
    public synchronized boolean isFree() {
        return prepared != null;
    }

    /** Returns the name of a text for messages; null for a compiled library. */
    @Nullable String source() {
        return source;
    }

    /**
     * Returns the handle for C. Throws an exception if an engine has taken the library or the
     * caller has closed it.
     */
    synchronized MemorySegment handle() {
        if (prepared == null) {
            throw new IllegalStateException(
                    "prepared library '"
                            + name
                            + "' was taken by an engine or closed; prepare it again");
        }
        return prepared;
    }

    /** Marks the handle as owned by an engine. */
    synchronized void taken() {
        prepared = null;
    }

    @Override
    public synchronized void close() {
        if (prepared != null) {
            LibraryFunctions.libraryDiscard(prepared);
            prepared = null;
        }
    }
}
