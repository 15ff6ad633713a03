// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.nio.file.Path;
import java.util.List;
import java.util.Map;

/**
 * An engine that applies laws to named property arrays of a client. Each law is an independently
 * compiled library. Any thread may call an engine, but only one call at a time is permitted. The
 * exception is {@code prepare}, which may run concurrently. Every method throws {@link
 * PhysicsException} if the engine refuses the call, and {@link IllegalStateException} after close.
 */
public interface PhysicsEngine extends AutoCloseable {
    /** Returns the engine's property provider, which lives as long as the engine. */
    PhysicalPropertyProvider propertyProvider();

    /** Returns the prototype for which the engine was created. */
    Prototype prototype();

    /**
     * Opens and checks a law library without activating it, which takes milliseconds. For any
     * thread, also during an advance.
     *
     * @param library a bare name, searched in the law path, or a path with a '/', used as is
     */
    PreparedLibrary prepare(String library);

    /** Opens and checks a law library from a file, like {@link #prepare(String)}. */
    PreparedLibrary prepare(Path file);

    /**
     * Opens a law library from a text, see docs/laws-as-text.md. Checks only the syntax; {@link
     * #loadPhysicsLaw} checks names and units. The message of a refusal has one line for each
     * problem, with its line number in the text. For any thread.
     *
     * @param source name of the text for messages, such as "wind.law"
     * @param text in UTF-8
     */
    PreparedLibrary prepareText(String source, byte[] text);

    /**
     * Checks a text against the prototype of this engine, without loading it, and returns all
     * problems with their line numbers; empty if there are none. For any thread.
     */
    String checkText(String source, byte[] text);

    /**
     * Opens and checks a law library from its bytes, like {@link #prepare(String)}. The caller must
     * not change the bytes.
     */
    PreparedLibrary prepare(byte[] library);

    /**
     * Activates a prepared library; call it between frames. The engine owns the library afterwards.
     * The caller still owns a library that the engine refuses.
     *
     * @param parameters values, keyed by {@code parameter} or {@code law.parameter}; omitted
     *     parameters have their default
     * @return id of the library within this engine; at least 1, never reused
     */
    int loadPhysicsLaw(PreparedLibrary prepared, Map<String, Double> parameters);

    /** Prepares and activates a library in one call. */
    default int loadPhysicsLaw(String library, Map<String, Double> parameters) {
        try (PreparedLibrary prepared = prepare(library)) {
            return loadPhysicsLaw(prepared, parameters);
        }
    }

    /**
     * Replaces a loaded library by a prepared library between two frames. The new library takes the
     * id and the place of the old library in the order of loading. It also takes the state of laws
     * for each row, where the layout of this state is the same. Its interval is 1. The engine may
     * refuse the new library, or the new library may fail. The old library then stays as it was,
     * and the caller still owns the new library.
     *
     * @param parameters as for {@link #loadPhysicsLaw(PreparedLibrary, Map)}
     */
    void replacePhysicsLaw(int libraryId, PreparedLibrary prepared, Map<String, Double> parameters);

    /** Unloads a library with all its laws. */
    void unloadPhysicsLaw(int libraryId);

    /**
     * Returns the loaded laws: libraries in the order of loading, laws in the order of their
     * library.
     */
    List<PhysicsLaw> laws();

    /** Returns the laws of one library; none if it is not loaded. */
    default List<PhysicsLaw> laws(int libraryId) {
        return laws().stream().filter(law -> law.libraryId() == libraryId).toList();
    }

    /**
     * Sets the interval at which the laws of a library are called. They are called in every step
     * whose number is a multiple of the interval. The engine multiplies the forces that the laws
     * add in these steps by the interval. The laws add no forces in all other steps, so their total
     * impulse stays the same. Each load of a library resets the interval to 1.
     *
     * @param interval 1 for every step, 0 for never; more than 1 only if all laws of the library
     *     are force laws that write no property
     */
    void setInterval(int libraryId, int interval);

    /**
     * Begins a series of changes, such as loading and unloading libraries, that can be undone as a
     * whole. Call it between frames.
     *
     * @throws IllegalStateException if a series has begun, or there is no process for the engine
     */
    void beginChanges();

    /**
     * Ends a series of changes, and keeps or undoes them. To undo changes, the engine restores its
     * libraries at {@link #beginChanges}, with their ids, order, parameters and intervals, and its
     * own state. The client restores the arrays. Undoing opens no library and needs no process, so
     * it cannot fail.
     *
     * @param keep true to keep the changes, false to undo them
     * @throws IllegalStateException if no series has begun
     */
    void endChanges(boolean keep);

    /** Returns whether the library runs in a sandbox, which can access only its columns. */
    default boolean isApart(int libraryId) {
        return false;
    }

    /**
     * Writes for each law the total wall-clock time of its calls since it was loaded [ns], in the
     * order of {@link #laws}. The method allocates nothing. The times are for reports and budgets
     * only.
     *
     * @param into long enough for all laws
     */
    void readTimes(long[] into);

    /**
     * Returns for how long the engine waited for a processor in the last advance [ns]; 0 if this
     * time is not known. The times of laws include this time.
     */
    default long waitedNanos() {
        return 0;
    }

    /**
     * Returns the values of one row of columns that laws have of their own, in the order of the
     * columns. A row without values yet is zero. Call it between frames.
     */
    List<double[]> ownValues(List<OwnColumn> columns, long row);

    /**
     * Applies all laws for {@code steps} steps of {@code dt}. Either all steps succeed, or none of
     * them counts. The engine is faulted after a failure, its time has not advanced, and properties
     * that laws may write are undefined. The client restores these properties and calls {@link
     * #clearFault}, or unloads the library that the exception names.
     *
     * @param dt length of a step [time unit of the prototype], above 0
     */
    void advance(double dt, int steps);

    /** Makes a faulted engine ready again, after the client has restored the arrays. */
    void clearFault();

    /**
     * Notifies the engine that the client moves rows of a kind, one after the other. Each move
     * takes row {@code from} to row {@code to <= from}, whose item was removed. The laws' state for
     * the moved item moves with it, and row {@code from} is a new row afterwards. {@code from ==
     * to} means that the item of that row was removed.
     *
     * @param moves from and to of each move; the engine keeps the array, which must not change
     */
    void moveRows(String kind, long[] moves);

    /**
     * Sets the step count, as if the arrays were the result of this many steps from time 0.
     *
     * @param steps 0 or more
     * @param dtSeconds length of each step [s]
     */
    void setStepCount(long steps, double dtSeconds);

    /**
     * Returns the number of steps since the engine was created, including the steps counted by
     * {@link #setStepCount} or {@link #loadState}.
     */
    long stepCount();

    /**
     * Returns a copy of the state that only the engine has: the step count, and the state of laws
     * for each row. This state and the arrays together continue a run with equal bits, in any
     * process. Call it between frames.
     */
    byte[] saveState();

    /**
     * Restores a saved state; the client restores the arrays. Changes nothing if the state is
     * damaged (INVALID_ARGUMENT), or belongs to another prototype or to other laws than the loaded
     * ones (ACCESS_CONFLICT).
     */
    void loadState(byte[] state);

    /**
     * Returns a hash of the step count and the bound properties: equal hashes mean equal states.
     */
    long stateHash();

    /**
     * Opens or closes the ledger, an account of the momentum and energy that each law adds. Opening
     * an open ledger restarts it. The engine records these contributions from the next advance on,
     * which costs a few passes over the bodies in each step. The ledger needs the properties mass,
     * position and velocity.
     */
    void setLedger(boolean on);

    /**
     * Returns the lines of the ledger as of the last successful advance. The ledger must be open.
     * The lines of the laws come first, in the order of {@link #laws}, then the lines client,
     * ground, unloaded and total.
     */
    List<LedgerLine> ledger();

    /** Unloads all laws and frees the engine. Idempotent. */
    @Override
    void close();
}
