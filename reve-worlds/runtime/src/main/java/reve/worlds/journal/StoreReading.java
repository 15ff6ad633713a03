// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.image.CorruptException;

import java.util.List;

/** The content of a store as it was read, and the damage that was found. For one thread. */
public interface StoreReading {
    /** Returns the store, for messages. */
    String name();

    /** Returns whether the store has never contained an image. */
    boolean isEmpty();

    /** Returns true if no stored data is lost. */
    boolean isWhole();

    /**
     * Returns one message for each damage. Each message names the damaged part. Damage that loses
     * data comes first.
     */
    List<String> problems();

    /** Returns the frame from which a world can resume; -1 for none. */
    long frame();

    /** Returns the newest frame that the store is known to have contained. */
    long knownFrame();

    /** Returns the records that restore the world: an image, and the frames that follow it. */
    List<JournalRecord> records();

    /**
     * Returns the SHA-256 of damaged libraries, as the store records it. The bytes of these
     * libraries have a different SHA-256.
     */
    List<String> damagedLibraries();

    /**
     * Refuses an incomplete store.
     *
     * @throws CorruptException with a message that states the missing data, the remaining data and
     *     a remedy
     */
    void requireWhole();

    /**
     * Returns an exception that states why a store is not opened.
     *
     * @param frame the frame from which the world could resume; -1 for none
     */
    CorruptException refusal(String reason, long frame);
}
