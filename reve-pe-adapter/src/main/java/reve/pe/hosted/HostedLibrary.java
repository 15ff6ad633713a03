// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import reve.pe.PreparedLibrary;
import reve.pe.posix.SharedMemory;
import reve.pe.vesper.LibraryFile;

import java.lang.foreign.MemorySegment;

/**
 * The bytes of a law library, in memory that hosts can read. This process does not load any of its
 * code.
 */
final class HostedLibrary implements PreparedLibrary {
    private final String source;
    private final byte[] bytes;
    private final String sha256;
    private final SharedMemory memory;
    private final Form form;
    private String name = "";
    private String versions = "";
    private boolean gone;

    /** The form of a library's bytes. The host uses the same numbers for these forms. */
    enum Form {
        NATIVE,
        TEXT,
        PYTHON,
        /** Form of native code that runs in a sandbox. */
        APART,
        /**
         * Form of native code that runs in a sandbox, even if the machine lacks a layer of the
         * sandbox.
         */
        APART_WEAKLY
    }

    /**
     * @param source names the library in messages
     */
    HostedLibrary(String source, byte[] bytes, Form form) {
        this.form = form;
        this.source = source;
        this.bytes = bytes;
        this.sha256 = LibraryFile.sha256(bytes);
        this.memory = new SharedMemory("law library", Math.max(1, bytes.length));
        MemorySegment.copy(MemorySegment.ofArray(bytes), 0, memory.segment(), 0, bytes.length);
    }

    /** Sets the name that the library itself declares, and the versions of the programs it uses. */
    HostedLibrary declared(String ownName, String usedVersions) {
        name = ownName;
        versions = usedVersions;
        return this;
    }

    /** Returns a library of the same bytes in other memory, which the caller closes. */
    HostedLibrary copy() {
        return new HostedLibrary(source, bytes, form);
    }

    String source() {
        return source;
    }

    /**
     * Returns a text that identifies the library. Two texts are equal only if the bytes and the
     * declared names are equal.
     */
    String identity() {
        return switch (form) {
            case NATIVE, TEXT -> sha256;
            case PYTHON -> sha256 + source; // a library in Python has the name of its file
            case APART, APART_WEAKLY -> sha256 + form;
        };
    }

    /** Returns whether the library runs in a sandbox. */
    boolean isApart() {
        return form == Form.APART || form == Form.APART_WEAKLY;
    }

    /** Appends the library to a request to open it. */
    Mailbox put(Mailbox request) {
        return request.putText(source)
                .putInt(form.ordinal())
                .putInt(memory.descriptor())
                .putLong(bytes.length);
    }

    @Override
    public String name() {
        return name;
    }

    @Override
    public String versions() {
        return versions;
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
        return !gone;
    }

    /** Refuses a library that an engine has taken, or that was closed. */
    synchronized void requireFree() {
        if (gone) {
            throw new IllegalStateException(
                    "prepared library '"
                            + name
                            + "' was taken by an engine or closed; prepare it again");
        }
    }

    /** Marks the library as owned by an engine, which frees it. */
    synchronized void taken() {
        gone = true;
    }

    /** Frees the memory of a library that an engine owned. */
    void free() {
        memory.close();
    }

    @Override
    public synchronized void close() {
        if (!gone) {
            gone = true;
            free();
        }
    }
}
