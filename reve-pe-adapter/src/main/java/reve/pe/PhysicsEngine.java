// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.Map;

/**
 * Holds named property arrays that belong to the client and applies laws to them, each an
 * independently compiled library. Thread-compatible: one call at a time, from any thread ({@code
 * prepare} excepted). Every method throws {@link PhysicsException} for what the engine refuses and
 * {@link IllegalStateException} once it is closed.
 */
public interface PhysicsEngine extends AutoCloseable {
    /** The engine's property provider; lives as long as the engine. */
    PhysicalPropertyProvider propertyProvider();

    /** What the engine was made for. */
    Prototype prototype();

    /**
     * Opens and checks a law library without activating it. Any thread, also during an advance;
     * takes milliseconds.
     *
     * @param library a bare name, searched in the law path, or a path with a '/', used as is
     */
    PreparedLibrary prepare(String library);

    /** Opens and checks the law library in a file, like {@link #prepare(String)}. */
    PreparedLibrary prepare(Path file);

    /** Opens and checks the law library that these bytes are, like {@link #prepare(String)}. */
    default PreparedLibrary prepare(byte[] library) {
        try {
            Path copy = Files.createTempFile("reve-law-", ".so");
            try {
                Files.write(copy, library);
                return prepare(copy);
            } finally {
                Files.delete(copy);
            }
        } catch (IOException e) {
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED,
                    "a law library could not be written to a temporary file to be opened: " + e);
        }
    }

    /**
     * Activates a prepared library, between frames. Takes it on success only.
     *
     * @param parameters by {@code parameter} or {@code law.parameter}; the rest keep their default
     * @return id of the library within this engine; at least 1, never reused
     */
    int loadPhysicsLaw(PreparedLibrary prepared, Map<String, Double> parameters);

    /** Prepares and activates in one call; see the two. */
    default int loadPhysicsLaw(String library, Map<String, Double> parameters) {
        try (PreparedLibrary prepared = prepare(library)) {
            return loadPhysicsLaw(prepared, parameters);
        }
    }

    /** Unloads a library with all its laws. */
    void unloadPhysicsLaw(int libraryId);

    /** The loaded laws: libraries in the order of loading, laws in the order of their library. */
    List<PhysicsLaw> laws();

    /**
     * Applies all laws for {@code steps} steps of {@code dt}: all count, or none. On failure the
     * engine is faulted, its time has not moved and what laws may write is undefined: restore it
     * and call {@link #clearFault}, or unload the library that the exception names.
     *
     * @param dt length of a step [time unit of the prototype], above 0
     */
    void advance(double dt, int steps);

    /** Makes a faulted engine ready again; the client has restored the arrays. */
    void clearFault();

    /**
     * Says that the client moves row {@code from} of a kind to row {@code to <= from}, whose own
     * item is gone: what laws remember of the item goes along, and row {@code from} is as new.
     * {@code from == to}: the item of that row is gone.
     */
    void moveRow(String kind, long from, long to);

    /**
     * Counts on as if steps of this length had been done from time 0, for arrays of such a run.
     *
     * @param steps 0 or more
     * @param dtSeconds length of each [s]
     */
    void setStepCount(long steps, double dtSeconds);

    /** Steps done since the engine was made, those that were set or loaded included. */
    long stepCount();

    /**
     * What lives in the engine and in no array of the client: the step count, and what laws
     * remember of each row. With the arrays it continues a run to the bit, in this process or
     * another one. A copy; between frames.
     */
    byte[] saveState();

    /**
     * Takes over a saved state; the client restores the arrays that belong to it. Nothing changes
     * if it is damaged (INVALID_ARGUMENT) or of another prototype or other laws than those that are
     * loaded (ACCESS_CONFLICT).
     */
    void loadState(byte[] state);

    /** Hash of step count and bound properties: equal hashes mean equal states. */
    long stateHash();

    /**
     * Opens the ledger, anew if it is open, or closes it: from the next advance on the engine books
     * what each law gives to the bodies, at the cost of a few passes over them in each step. Needs
     * the properties mass, position and velocity.
     */
    void setLedger(boolean on);

    /**
     * The open ledger as of the last advance that succeeded: the laws in the order of {@link
     * #laws}, then client, ground, unloaded and total.
     */
    List<LedgerLine> ledger();

    /** Unloads every law and frees the engine. May be called twice. */
    @Override
    void close();
}
