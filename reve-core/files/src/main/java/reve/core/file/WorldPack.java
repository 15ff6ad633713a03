// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import org.jspecify.annotations.Nullable;

import reve.core.disk.PartFile;

import java.io.EOFException;
import java.io.IOException;
import java.io.InputStream;
import java.io.OutputStream;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.channels.FileChannel;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.nio.file.StandardOpenOption;
import java.time.LocalDateTime;
import java.util.Collections;
import java.util.Map;
import java.util.SortedMap;
import java.util.TreeSet;
import java.util.zip.CRC32;
import java.util.zip.ZipEntry;
import java.util.zip.ZipException;
import java.util.zip.ZipFile;
import java.util.zip.ZipOutputStream;

/**
 * A world with all of its files in one file. This file is a zip archive with a {@value
 * WorldFile#NAME} at its root. The files are stored in the order of their names, with one fixed
 * date and without compression. Therefore the same files give the same bytes on each machine. This
 * class has no state. For any thread.
 */
public final class WorldPack {
    /** Ending of the file name of a pack. */
    public static final String ENDING = ".reve";

    /** Maximum number of files of a pack. */
    public static final int MAX_FILES = 4096;

    /** Maximum size of all files of a pack together [bytes]. */
    public static final long MAX_BYTES = 384L << 20;

    /** Maximum size of the list of files at the end of a pack [bytes]. */
    private static final int MAX_LIST_BYTES = 8 << 20;

    private static final int FIRST_SIGNATURE = 0x04034b50;
    private static final int LIST_SIGNATURE = 0x02014b50;
    private static final int END_SIGNATURE = 0x06054b50;
    private static final int LIST_ENTRY_BYTES = 46;
    private static final int END_BYTES = 22;
    private static final int FILE_KIND = 0170000;
    private static final int REGULAR = 0100000;
    private static final int FOLDER = 0040000;
    private static final LocalDateTime DATE = LocalDateTime.of(1980, 1, 1, 0, 0);

    private WorldPack() {}

    /** Returns whether a file is a pack according to its name or its first bytes. */
    public static boolean isPack(Path file) {
        if (!Files.isRegularFile(file)) {
            return false;
        }
        if (file.toString().endsWith(ENDING)) {
            return true;
        }
        try (InputStream in = Files.newInputStream(file)) {
            byte[] begin = in.readNBytes(Integer.BYTES);
            return begin.length == Integer.BYTES && little(begin).getInt() == FIRST_SIGNATURE;
        } catch (IOException unreadable) {
            return false; // the reader of world files will report that the file is unreadable
        }
    }

    /**
     * Writes a pack atomically.
     *
     * @param files files by their names in the pack, which are separated by {@code /}
     * @throws PackException if the files exceed the limits, or some file system could treat two
     *     names as one
     */
    public static void write(Path pack, SortedMap<String, Path> files) throws IOException {
        write(pack, files, Map.of());
    }

    /**
     * Writes a pack like {@link #write(Path, SortedMap)}, with further files that are in memory.
     *
     * @param made contents by their names in the pack; no name may also be in {@code files}
     */
    public static void write(Path pack, SortedMap<String, Path> files, Map<String, byte[]> made)
            throws IOException {
        var all = new TreeSet<>(files.keySet());
        all.addAll(made.keySet());
        var names = new PackNames(pack);
        for (String name : all) {
            byte[] content = made.get(name);
            names.add(name);
            names.take(name, content == null ? Files.size(files.get(name)) : content.length);
        }
        Path target = pack.toAbsolutePath();
        Path part = PartFile.create(target);
        try {
            try (OutputStream out = Files.newOutputStream(part);
                    ZipOutputStream zip = new ZipOutputStream(out, StandardCharsets.UTF_8)) {
                for (String name : all) {
                    byte[] content = made.get(name);
                    store(
                            zip,
                            name,
                            content == null ? Files.readAllBytes(files.get(name)) : content);
                }
            }
            PartFile.move(part, target, StandardCopyOption.ATOMIC_MOVE);
        } finally {
            PartFile.remove(part);
        }
    }

    private static void store(ZipOutputStream zip, String name, byte[] content) throws IOException {
        CRC32 sum = new CRC32();
        sum.update(content);
        ZipEntry entry = new ZipEntry(name);
        entry.setMethod(ZipEntry.STORED);
        entry.setTimeLocal(DATE);
        entry.setSize(content.length);
        entry.setCrc(sum.getValue());
        zip.putNextEntry(entry);
        zip.write(content);
        zip.closeEntry();
    }

    /**
     * Writes the files of a pack into an empty folder. The folder may contain some of these files
     * after a failure.
     *
     * @throws PackException if the pack is damaged, exceeds the limits, has no world file, or
     *     contains a name that leads out of the folder
     */
    public static void unpack(Path pack, Path folder) throws IOException {
        requireForm(pack);
        var names = new PackNames(pack);
        try (ZipFile zip = new ZipFile(pack.toFile(), StandardCharsets.UTF_8)) {
            for (ZipEntry entry : Collections.list(zip.entries())) {
                names.add(entry.getName());
            }
            if (zip.getEntry(WorldFile.NAME) == null) {
                throw new PackException(
                        pack
                                + ": there is no "
                                + WorldFile.NAME
                                + " at its root; make a pack with: reve pack WORLD");
            }
            for (ZipEntry entry : Collections.list(zip.entries())) {
                if (!entry.isDirectory()) {
                    extract(pack, zip, entry, folder, names);
                }
            }
        } catch (ZipException | EOFException | IllegalArgumentException broken) {
            throw damaged(pack, String.valueOf(broken.getMessage()), broken);
        }
    }

    /**
     * Writes one file of a pack. Checks the number of bytes that were really read against the
     * limits, because the stated number may be wrong.
     */
    private static void extract(
            Path pack, ZipFile zip, ZipEntry entry, Path folder, PackNames names)
            throws IOException {
        Path target = folder.resolve(entry.getName());
        Files.createDirectories(target.getParent());
        CRC32 sum = new CRC32();
        byte[] buffer = new byte[1 << 16];
        try (InputStream in = zip.getInputStream(entry);
                OutputStream out = Files.newOutputStream(target, StandardOpenOption.CREATE_NEW)) {
            for (int count = in.read(buffer); count >= 0; count = in.read(buffer)) {
                names.take(entry.getName(), count);
                sum.update(buffer, 0, count);
                out.write(buffer, 0, count);
            }
        } catch (EOFException cut) {
            throw damaged(pack, entry.getName() + " is cut off", cut);
        }
        if (sum.getValue() != entry.getCrc()) {
            throw damaged(pack, entry.getName() + " has another checksum than stated", null);
        }
    }

    /**
     * Checks the list of files at the end of a pack before a library reads the list into memory.
     * The list must not be too large, and all its entries must be files or folders.
     */
    private static void requireForm(Path pack) throws IOException {
        try (FileChannel file = FileChannel.open(pack)) {
            long size = file.size();
            if (size > MAX_BYTES + MAX_LIST_BYTES) {
                throw new PackException(
                        pack
                                + ": has "
                                + size
                                + " bytes, expected at most "
                                + (MAX_BYTES + MAX_LIST_BYTES));
            }
            if (size < END_BYTES) {
                throw damaged(pack, "it has " + size + " bytes", null);
            }
            ByteBuffer end = read(file, size - END_BYTES, END_BYTES);
            if (end.getInt(0) != END_SIGNATURE) {
                throw damaged(pack, "its list of files is missing", null);
            }
            int count = Short.toUnsignedInt(end.getShort(10));
            long bytes = Integer.toUnsignedLong(end.getInt(12));
            if (count > MAX_FILES) {
                throw tooMany(pack, count);
            }
            if (bytes > MAX_LIST_BYTES || bytes > size - END_BYTES) {
                throw damaged(pack, "its list of files states " + bytes + " bytes", null);
            }
            requireNoLinks(pack, read(file, size - END_BYTES - bytes, (int) bytes));
        }
    }

    private static void requireNoLinks(Path pack, ByteBuffer list) throws PackException {
        int place = 0;
        while (place <= list.capacity() - LIST_ENTRY_BYTES) {
            if (list.getInt(place) != LIST_SIGNATURE) {
                throw damaged(pack, "its list of files is broken", null);
            }
            int kind = list.getShort(place + 40) & FILE_KIND;
            if (kind != 0 && kind != REGULAR && kind != FOLDER) {
                throw new PackException(
                        pack
                                + ": has a link or a special file, expected files and folders only;"
                                + " replace it by the file itself");
            }
            place +=
                    LIST_ENTRY_BYTES
                            + Short.toUnsignedInt(list.getShort(place + 28))
                            + Short.toUnsignedInt(list.getShort(place + 30))
                            + Short.toUnsignedInt(list.getShort(place + 32));
        }
    }

    private static ByteBuffer read(FileChannel file, long place, int count) throws IOException {
        byte[] bytes = new byte[count];
        ByteBuffer into = ByteBuffer.wrap(bytes);
        while (into.hasRemaining() && file.read(into, place + into.position()) >= 0) {
            // The loop body is empty. A call of read() may return fewer bytes than requested, so it
            // is repeated until all bytes are read.
        }
        return little(bytes);
    }

    private static ByteBuffer little(byte[] bytes) {
        return ByteBuffer.wrap(bytes).order(ByteOrder.LITTLE_ENDIAN);
    }

    static PackException tooMany(Path pack, int count) {
        return new PackException(pack + ": has " + count + " files, expected at most " + MAX_FILES);
    }

    private static PackException damaged(Path pack, String what, @Nullable Throwable cause) {
        return new PackException(
                pack + ": is no whole pack: " + what + "; copy it again, or pack the world again",
                cause);
    }
}
