// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.pe.PreparedLibrary;
import reve.worlds.journal.JournalRecord;

import java.io.IOException;
import java.io.UncheckedIOException;
import java.nio.file.DirectoryStream;
import java.nio.file.Files;
import java.nio.file.Path;
import java.security.MessageDigest;
import java.security.NoSuchAlgorithmException;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.HexFormat;
import java.util.List;
import java.util.Map;
import java.util.function.Consumer;

/**
 * Finds law libraries on disk by the SHA-256 of their bytes, to replace damaged libraries of a
 * store. For one thread.
 */
final class LawFiles {
    private final List<Path> folders;
    private final Consumer<String> found;
    private final Map<String, byte[]> given = new HashMap<>();
    private @Nullable Map<String, Path> files;

    /**
     * Searches the shipped laws and the operator's folder.
     *
     * @param found receives a message for each library that replaces a damaged one
     */
    LawFiles(LawPath laws, Consumer<String> found) {
        folders = new ArrayList<>(List.of(laws.shipped()));
        laws.folder().ifPresent(folders::add);
        laws.sandboxed().folder().ifPresent(folders::add);
        this.found = found;
    }

    /** Returns the bytes of a library, or null if it was not found. */
    byte @Nullable [] find(String sha256) {
        byte[] before = given.get(sha256);
        if (before != null) {
            return before;
        }
        if (files == null) {
            files = list();
        }
        Path file = files.get(sha256);
        if (file == null) {
            return null;
        }
        try {
            byte[] bytes = Files.readAllBytes(file);
            if (!sha256(bytes).equals(sha256)) {
                return null;
            }
            given.put(sha256, bytes);
            found.accept(
                    "the law library with the SHA-256 "
                            + sha256
                            + " is damaged or missing; the same bytes are in "
                            + file
                            + ", which is used");
            return bytes;
        } catch (IOException e) {
            throw new UncheckedIOException(file + " could not be read", e);
        }
    }

    /** Returns the libraries that were found. */
    List<JournalRecord.Library> given() {
        return given.entrySet().stream()
                .map(each -> new JournalRecord.Library(each.getKey(), each.getValue()))
                .toList();
    }

    private Map<String, Path> list() {
        Map<String, Path> all = new HashMap<>();
        for (Path folder : folders) {
            if (!Files.isDirectory(folder)) {
                continue;
            }
            try (DirectoryStream<Path> libraries =
                    Files.newDirectoryStream(folder, "*.{so,law,py}")) {
                for (Path library : libraries) {
                    if (Files.isRegularFile(library)
                            && Files.isReadable(library)
                            && Files.size(library) <= PreparedLibrary.MAX_BYTES) {
                        all.putIfAbsent(sha256(Files.readAllBytes(library)), library);
                    }
                }
            } catch (IOException e) {
                throw new UncheckedIOException(folder + " could not be read", e);
            }
        }
        return all;
    }

    static String sha256(byte[] bytes) {
        try {
            return HexFormat.of().formatHex(MessageDigest.getInstance("SHA-256").digest(bytes));
        } catch (NoSuchAlgorithmException e) {
            throw new AssertionError("every Java platform has SHA-256", e);
        }
    }
}
