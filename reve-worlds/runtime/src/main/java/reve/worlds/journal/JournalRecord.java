// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

/** A record of a journal, independent of the storage. The first record of a journal is an image. */
public sealed interface JournalRecord {
    /** A law library. Later records refer to it by the SHA-256 of its bytes. */
    record Library(String sha256, byte[] bytes) implements JournalRecord {}

    /** The complete state at the end of a frame, encoded by {@link ImageCodec}. */
    record Image(long frame, byte[] bytes) implements JournalRecord {}

    /** The inputs and the digest of a frame: JSON, encoded by {@link FrameCodec}. */
    record Frame(long frame, byte[] json) implements JournalRecord {}
}
