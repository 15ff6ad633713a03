// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/**
 * A law library that is opened and checked, and can be activated quickly. The caller owns it until
 * an engine takes it. If no engine takes it, the caller closes it (any thread, before the engine
 * that prepared it).
 */
public interface PreparedLibrary extends AutoCloseable {
    /** Maximum size of a law library [bytes]. */
    int MAX_BYTES = 1 << 28;

    /** Maximum size of a law as text [bytes]. */
    int MAX_TEXT_BYTES = 65_536;

    /** End of the names of files with a law as text. */
    String TEXT_ENDING = ".law";

    /**
     * Returns whether a library is a text, which is safe by construction, and not native code: such
     * a library begins with the sign of ELF files.
     */
    static boolean isText(byte[] library) {
        return library.length < 4
                || library[0] != 0x7f
                || library[1] != 'E'
                || library[2] != 'L'
                || library[3] != 'F';
    }

    /** Returns the library's own name. */
    String name();

    /** Returns the SHA-256 of the library's bytes, 64 lower-case hexadecimal digits. */
    String sha256();

    /** Returns the library's bytes; the caller must not change them. */
    byte[] bytes();

    /** Frees the library if no engine took it. Idempotent. */
    @Override
    void close();
}
