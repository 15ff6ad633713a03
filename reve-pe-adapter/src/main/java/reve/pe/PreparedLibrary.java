// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/**
 * A law library that is opened and checked, ready to be activated in an instant. Owned by the
 * caller until an engine takes it; close it (any thread, before the engine that prepared it) if
 * none does.
 */
public interface PreparedLibrary extends AutoCloseable {
    /** Maximum size of a law library [bytes]. */
    int MAX_BYTES = 1 << 28;

    /** Name that the library gives itself. */
    String name();

    /** SHA-256 of the library's bytes, 64 lower-case hexadecimal digits. */
    String sha256();

    /** The library's bytes; the caller does not change them. */
    byte[] bytes();

    /** Drops the library if no engine took it. May be called twice. */
    @Override
    void close();
}
