// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.pe.PhysicsException;

import java.util.Optional;
import java.util.function.LongConsumer;

/**
 * A new version of a loaded library, or new parameters for it, that has not replaced the library
 * yet. For the world's thread, except where noted. The owner closes it.
 *
 * @param libraryId id of the loaded library, which stays the same
 * @param library the new version, with its parameters
 * @param source name of the file or text, for messages
 * @param parametersOnly true if the bytes are those of the loaded library
 * @param taking function that replaces the loaded library; its argument is the frame
 * @param ended receives the end of the trial
 * @param freeing function that frees the library; for any thread
 */
public record NewVersion(
        int libraryId,
        LawLibrary library,
        String source,
        boolean parametersOnly,
        LongConsumer taking,
        Ended ended,
        Runnable freeing)
        implements AutoCloseable {
    /** A listener for the end of the trial of a new version. */
    @FunctionalInterface
    public interface Ended {
        /** A listener that does nothing. */
        Ended UNHEARD = (frame, refusal) -> {};

        /**
         * Receives the end of a trial. Called on the world's thread.
         *
         * @param refusal the reason why the loaded library stays; empty if the new version replaced
         *     it
         */
        void ended(long frame, Optional<PhysicsException> refusal);
    }

    /** Returns this version with a listener for its end. */
    public NewVersion heardBy(Ended listener) {
        return new NewVersion(
                libraryId, library, source, parametersOnly, taking, listener, freeing);
    }

    /**
     * Replaces the loaded library, outside PHYSICS.
     *
     * @throws PhysicsException if the version is refused; nothing has changed in this case
     */
    public void take(long frame) {
        taking.accept(frame);
    }

    /**
     * Returns the change that loads this version in an equal world, for example in a copy.
     *
     * @param place place of the loaded library in the order of loading
     */
    public LawChange change(int place) {
        return parametersOnly
                ? new LawChange.ParametersSet(place, library.parameters())
                : new LawChange.Replaced(place, library);
    }

    /** Frees the library, unless the engine has taken it. Idempotent; for any thread. */
    @Override
    public void close() {
        freeing.run();
    }
}
