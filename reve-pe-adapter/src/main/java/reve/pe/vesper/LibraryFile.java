package reve.pe.vesper;

import java.io.IOException;
import java.io.UncheckedIOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.attribute.BasicFileAttributes;
import java.nio.file.attribute.FileTime;
import java.security.MessageDigest;
import java.security.NoSuchAlgorithmException;
import java.util.Comparator;
import java.util.HexFormat;
import java.util.List;
import java.util.SortedSet;
import java.util.TreeSet;
import java.util.stream.IntStream;
import java.util.stream.Stream;
import org.jspecify.annotations.Nullable;
import reve.pe.PhysicsException;
import reve.pe.Status;

/** A law library on disk: where a name leads to, and what its bytes are. */
final class LibraryFile {
    private static final String PREFIX = "libvesper_law_";
    private static final String SUFFIX = ".so";

    private LibraryFile() {
    }

    /** What tells one content of a file from another without reading it. */
    record Stamp(@Nullable Object key, long size, FileTime modified) {
    }

    /**
     * Finds a library by the rule of {@code vesper_library_prepare}; the path is absolute.
     *
     * @throws PhysicsException NOT_FOUND
     */
    static Path find(String library, List<Path> lawPath) {
        if (library.contains("/")) {
            return existing(library, List.of(Path.of(library)), "");
        }
        String file = PREFIX + library + SUFFIX;
        return existing(library, lawPath.stream().map(folder -> folder.resolve(file)).toList(),
            hint(library, known(lawPath)));
    }

    private static Path existing(String library, List<Path> candidates, String hint) {
        return candidates.stream().filter(Files::exists).findFirst().map(Path::toAbsolutePath)
            .orElseThrow(() -> new PhysicsException(Status.NOT_FOUND,
                "law library '" + library + "' was not found" + hint));
    }

    /** Names that the law path has, in alphabetical order. */
    private static List<String> known(List<Path> lawPath) {
        SortedSet<String> names = new TreeSet<>();
        for (Path folder : lawPath) {
            try (Stream<Path> files = Files.list(folder)) {
                files.map(file -> file.getFileName().toString())
                    .filter(file -> file.startsWith(PREFIX) && file.endsWith(SUFFIX))
                    .forEach(file -> names.add(file.substring(PREFIX.length(),
                        file.length() - SUFFIX.length())));
            } catch (IOException | UncheckedIOException unreadable) {
                // then it has none that could be meant
            }
        }
        return List.copyOf(names);
    }

    /** The name that was probably meant, or else all that are known. */
    private static String hint(String wrong, List<String> known) {
        int limit = Math.max(1, wrong.length() / 3);
        return known.stream().filter(name -> distance(wrong, name) <= limit)
            .min(Comparator.comparingInt(name -> distance(wrong, name)))
            .map(name -> "; did you mean '" + name + "'?")
            .orElse(known.isEmpty() ? "; the law path has none"
                : "; known are " + String.join(", ", known));
    }

    /** Fewest insertions, deletions and replacements between two texts. */
    private static int distance(String a, String b) {
        int[] row = IntStream.rangeClosed(0, b.length()).toArray();
        for (int i = 1; i <= a.length(); i++) {
            int diagonal = row[0];
            row[0] = i;
            for (int j = 1; j <= b.length(); j++) {
                int replaced = diagonal + (a.charAt(i - 1) == b.charAt(j - 1) ? 0 : 1);
                diagonal = row[j];
                row[j] = Math.min(replaced, Math.min(row[j], row[j - 1]) + 1);
            }
        }
        return row[b.length()];
    }

    static Stamp stamp(Path file) throws IOException {
        BasicFileAttributes attributes = Files.readAttributes(file, BasicFileAttributes.class);
        return new Stamp(attributes.fileKey(), attributes.size(), attributes.lastModifiedTime());
    }

    /** 64 lower-case hexadecimal digits. */
    static String sha256(byte[] bytes) {
        try {
            return HexFormat.of().formatHex(MessageDigest.getInstance("SHA-256").digest(bytes));
        } catch (NoSuchAlgorithmException e) {
            throw new AssertionError("every Java platform has SHA-256", e);
        }
    }
}
