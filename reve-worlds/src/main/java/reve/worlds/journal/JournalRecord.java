// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

/** A record of a journal, whatever it is kept in. A journal begins with an image. */
public sealed interface JournalRecord {
    /** A law library that later records name by the SHA-256 of its bytes. */
    record Library(String sha256, byte[] bytes) implements JournalRecord {}

    /** Everything at the end of a frame, as {@link ImageCodec} writes it. */
    record Image(long frame, byte[] bytes) implements JournalRecord {}

    /** What came into a frame, and its digest: JSON as {@link FrameCodec} writes it. */
    record Frame(long frame, byte[] json) implements JournalRecord {}
}
