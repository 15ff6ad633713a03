// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static java.lang.foreign.ValueLayout.ADDRESS;
import static java.lang.foreign.ValueLayout.JAVA_BYTE;

import reve.pe.PhysicsException;
import reve.pe.PreparedLibrary;
import reve.pe.Prototype;
import reve.pe.Status;
import reve.pe.posix.RegularFile;

import java.io.IOException;
import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.nio.file.Files;
import java.nio.file.Path;

/**
 * A law library that is a text. A text cannot harm the process, so it needs no test in another
 * process.
 */
public final class LawText {

    /** Maximum size of the report of all problems [bytes]. */
    private static final int MAX_REPORT = 16_384;

    private LawText() {}

    /**
     * Reads the file of a law as text.
     *
     * @throws PhysicsException if it is too large
     */
    public static byte[] read(Path file) throws IOException {
        if (Files.size(file) > PreparedLibrary.MAX_TEXT_BYTES) {
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED,
                    file
                            + " has "
                            + Files.size(file)
                            + " bytes, expected a law text of at most "
                            + PreparedLibrary.MAX_TEXT_BYTES);
        }
        return RegularFile.read(file, PreparedLibrary.MAX_TEXT_BYTES);
    }

    /**
     * Returns the name of the library.
     *
     * @param source name of the text for messages
     * @throws PhysicsException with a line for each problem, if the syntax is wrong
     */
    public static String name(Prototype prototype, String source, byte[] text) {
        MemorySegment prepared = prepare(prototype, source, text);
        try {
            return VesperStrings.read(LibraryFunctions.libraryName(prepared));
        } finally {
            LibraryFunctions.libraryDiscard(prepared);
        }
    }

    /** Returns all problems of a text with their line numbers; empty if there are none. */
    public static String check(Prototype prototype, String source, byte[] text) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment report = call.allocate(MAX_REPORT);
            VesperErrors failure = new VesperErrors(call, id -> null);
            failure.check(
                    LibraryFunctions.textCheck(
                            VesperPrototypes.write(call, prototype),
                            VesperStrings.write(call, source),
                            copy(call, text),
                            report,
                            failure.segment()));
            return VesperStrings.readInline(report, 0, MAX_REPORT).stripTrailing();
        }
    }

    /** Opens a text. The caller must discard the returned handle or pass it to an engine. */
    static MemorySegment prepare(Prototype prototype, String source, byte[] text) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment handle = call.allocate(ADDRESS);
            VesperErrors failure = new VesperErrors(call, id -> null);
            int status =
                    LibraryFunctions.libraryPrepareText(
                            VesperStrings.write(call, source),
                            copy(call, text),
                            handle,
                            failure.segment());
            if (status != 0) {
                throw withReport(prototype, source, text, failure.exception(status));
            }
            return handle.get(ADDRESS, 0);
        }
    }

    /**
     * Returns an exception with all problems of the text and their line numbers. Returns the given
     * exception if the text has no problems.
     */
    public static PhysicsException withReport(
            Prototype prototype, String source, byte[] text, PhysicsException refusal) {
        String report = check(prototype, source, text);
        return report.isEmpty() ? refusal : new PhysicsException(refusal.status(), report);
    }

    private static MemorySegment copy(Arena arena, byte[] text) {
        MemorySegment copy = arena.allocate(Math.max(1, text.length));
        MemorySegment.copy(text, 0, copy, JAVA_BYTE, 0, text.length);
        return copy.asSlice(0, text.length);
    }
}
