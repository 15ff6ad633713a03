// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import org.jspecify.annotations.Nullable;

import reve.pe.PhysicsException;
import reve.pe.PreparedLibrary;
import reve.pe.Status;
import reve.pe.posix.RegularFile;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.LinkOption;
import java.nio.file.Path;
import java.nio.file.attribute.BasicFileAttributes;
import java.nio.file.attribute.FileTime;
import java.security.MessageDigest;
import java.security.NoSuchAlgorithmException;
import java.util.HexFormat;
import java.util.List;

/** Functions for a law library on disk: find its path by its name, read and identify its bytes. */
public final class LibraryFile {
    private LibraryFile() {}

    /** The identity of a file's content as far as it is known without reading the file. */
    record Stamp(@Nullable Object key, long size, FileTime modified) {}

    /**
     * Finds a library by the rule of {@code vesper_library_prepare}; the path is absolute.
     *
     * @throws PhysicsException with the status NOT_FOUND if there is no such library
     */
    public static Path find(String library, List<Path> lawPath) {
        if (library.contains("/")) {
            return existing(library, List.of(Path.of(library)));
        }
        String text = PreparedLibrary.TEXT_ENDING;
        String python = PreparedLibrary.PYTHON_ENDING;
        List<String> files =
                library.endsWith(text) || library.endsWith(python)
                        ? List.of(library)
                        : List.of(
                                "libvesper_law_" + library + ".so",
                                library + text,
                                library + python);
        return existing(
                library,
                lawPath.stream().flatMap(folder -> files.stream().map(folder::resolve)).toList());
    }

    private static Path existing(String library, List<Path> candidates) {
        return candidates.stream()
                .filter(Files::exists)
                .findFirst()
                .map(Path::toAbsolutePath)
                .orElseThrow(
                        () ->
                                new PhysicsException(
                                        Status.NOT_FOUND,
                                        "law library '"
                                                + library
                                                + "' was not found; looked for "
                                                + candidates));
    }

    /**
     * Reads a library.
     *
     * @throws PhysicsException if it is too large, or changes while it is read
     * @throws IOException if it cannot be read or is not a regular file
     */
    public static byte[] read(Path file) throws IOException {
        Stamp before = stamp(file);
        requireSize(file);
        byte[] bytes = RegularFile.read(file, most(file));
        requireUnchanged(file, before);
        return bytes;
    }

    static void requireSize(Path file) throws IOException {
        if (Files.size(file) > most(file)) {
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED,
                    file
                            + " has "
                            + Files.size(file)
                            + " bytes, expected a law library of at most "
                            + most(file));
        }
    }

    private static int most(Path file) {
        return file.toString().endsWith(PreparedLibrary.PYTHON_ENDING)
                ? PreparedLibrary.MAX_PYTHON_BYTES
                : PreparedLibrary.MAX_BYTES;
    }

    static void requireUnchanged(Path file, Stamp before) throws IOException {
        if (!stamp(file).equals(before)) {
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED,
                    file + " changed while it was being read; try again when it is complete");
        }
    }

    static Stamp stamp(Path file) throws IOException {
        BasicFileAttributes attributes =
                Files.readAttributes(file, BasicFileAttributes.class, LinkOption.NOFOLLOW_LINKS);
        return new Stamp(attributes.fileKey(), attributes.size(), attributes.lastModifiedTime());
    }

    /** Returns 64 lower-case hexadecimal digits. */
    public static String sha256(byte[] bytes) {
        try {
            return HexFormat.of().formatHex(MessageDigest.getInstance("SHA-256").digest(bytes));
        } catch (NoSuchAlgorithmException e) {
            throw new AssertionError("every Java platform has SHA-256", e);
        }
    }
}
