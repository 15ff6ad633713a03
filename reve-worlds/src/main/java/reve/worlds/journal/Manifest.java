// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.store.CorruptException;

import java.io.IOException;
import java.io.InputStream;
import java.nio.ByteBuffer;
import java.nio.channels.FileChannel;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.util.Optional;
import java.util.UUID;
import java.util.zip.CRC32C;

/**
 * The file STORE-manifest: the least that the other files of a store must hold. It is written in
 * place, by one small write after each frame and each image, so it never claims what is not there;
 * files that hold less than it claims have lost something. It names a file of frames before that
 * holds any, and is on the disk before the image that begins the file is committed: if it does not
 * name it, it is an older copy, and says nothing about the newest frames. Any thread.
 */
final class Manifest implements AutoCloseable {
    private static final byte[] MARK =
            "REVE store manifest 1\n".getBytes(StandardCharsets.US_ASCII);
    private static final int BYTES = MARK.length + 10 * Long.BYTES + Integer.BYTES;
    private static final int FRAME_AT = MARK.length + 6 * Long.BYTES;
    private static final Path BOOT = Path.of("/proc/sys/kernel/random/boot_id");

    private final Path file;
    private final FileChannel channel;
    private final FilePlace place;
    private final ByteBuffer block = ByteBuffer.allocateDirect(BYTES);
    private Claim claim;
    private long frame;

    /**
     * What a manifest says.
     *
     * @param store identity of the store
     * @param boot identity of the machine's start in which it was written
     * @param file number of the newest file of frames, and its identity
     * @param frame that was written last, or shown by the image that was written last
     * @param image number of the newest image, 0 without any; its frame and its checksum
     */
    record Claim(
            UUID store,
            UUID boot,
            long file,
            long fileId,
            long frame,
            long image,
            long imageFrame,
            long imageSum) {
        static Claim nothing(UUID store) {
            return new Claim(store, thisBoot(), 0, 0, 0, 0, 0, 0);
        }

        /** Whether the machine was started again since: a power failure may have cost frames. */
        boolean isOfAnotherBoot() {
            return !boot.equals(thisBoot());
        }
    }

    /**
     * Opens the manifest or makes it; the claim is written at once.
     *
     * @throws IOException naming the file and the reason
     */
    Manifest(Path store, Claim claim) throws IOException {
        file = path(store);
        this.claim = claim;
        if (Files.exists(file) && !Files.isRegularFile(file)) { // opening a pipe waits for a reader
            throw new IOException(
                    file
                            + " is no regular file, expected a file of the store "
                            + store
                            + "; move it away");
        }
        try {
            channel = FileChannel.open(file, StandardOpenOption.CREATE, StandardOpenOption.WRITE);
        } catch (IOException e) {
            throw failed(e);
        }
        try {
            place = FilePlace.of(file);
            write(claim);
            channel.truncate(BYTES).force(true);
        } catch (IOException e) {
            channel.close();
            throw e;
        }
    }

    static Path path(Path store) {
        return store.resolveSibling(store.getFileName() + "-manifest");
    }

    /**
     * What the manifest of a store claims, empty if there is no manifest or an empty one.
     *
     * @throws CorruptException if it is damaged or no manifest
     */
    static Optional<Claim> read(Path store) throws IOException {
        Path file = path(store);
        Optional<String> no = FileTrouble.noFile(file);
        if (no.isPresent()) {
            throw new CorruptException(no.get());
        }
        if (!Files.exists(file) || Files.size(file) == 0) {
            return Optional.empty();
        }
        byte[] bytes;
        try (InputStream in = Files.newInputStream(file)) {
            long size = Files.size(file);
            if (size != BYTES) {
                throw new CorruptException(
                        file + " is damaged: it has " + size + " bytes, expected " + BYTES);
            }
            bytes = in.readNBytes(BYTES);
        } catch (IOException e) {
            throw FileTrouble.of(file, "read", e);
        }
        ByteBuffer block = ByteBuffer.wrap(bytes);
        if (bytes.length != BYTES
                || !ByteBuffer.wrap(MARK).equals(block.slice(0, MARK.length))
                || block.getInt(BYTES - Integer.BYTES) != sum(block)) {
            throw new CorruptException(file + " is damaged");
        }
        block.position(MARK.length);
        return Optional.of(
                new Claim(
                        new UUID(block.getLong(), block.getLong()),
                        new UUID(block.getLong(), block.getLong()),
                        block.getLong(),
                        block.getLong(),
                        block.getLong(),
                        block.getLong(),
                        block.getLong(),
                        block.getLong()));
    }

    /** Another file of frames has begun. */
    synchronized void begin(long number, long id) throws IOException {
        write(
                new Claim(
                        claim.store,
                        claim.boot,
                        number,
                        id,
                        frame,
                        claim.image,
                        claim.imageFrame,
                        claim.imageSum));
    }

    /** A frame was written. */
    synchronized void reach(long newest) throws IOException {
        frame = newest;
        block.putLong(FRAME_AT, newest);
        write();
    }

    /** An image was written. */
    synchronized void keep(long image, long itsFrame, long sum) throws IOException {
        write(
                new Claim(
                        claim.store,
                        claim.boot,
                        claim.file,
                        claim.fileId,
                        Math.max(frame, itsFrame),
                        image,
                        itsFrame,
                        sum));
    }

    /** Waits until what it says outlives a power failure. */
    void force() throws IOException {
        try {
            channel.force(false);
        } catch (IOException e) {
            throw failed(e);
        }
    }

    /** What became of the file, as a line; empty if all of it is where it was made. */
    String trouble() {
        String what = place.trouble(BYTES);
        return what.isEmpty() ? "" : file + " " + what;
    }

    synchronized Claim claim() {
        return new Claim(
                claim.store,
                claim.boot,
                claim.file,
                claim.fileId,
                frame,
                claim.image,
                claim.imageFrame,
                claim.imageSum);
    }

    @Override
    public void close() throws IOException {
        channel.close();
    }

    private void write(Claim now) throws IOException {
        block.clear().put(MARK);
        put(now.store);
        put(now.boot);
        block.putLong(now.file)
                .putLong(now.fileId)
                .putLong(now.frame)
                .putLong(now.image)
                .putLong(now.imageFrame)
                .putLong(now.imageSum);
        claim = now;
        frame = now.frame;
        write();
    }

    private void write() throws IOException {
        block.putInt(BYTES - Integer.BYTES, sum(block)).clear();
        try {
            for (int at = 0; block.hasRemaining(); ) {
                at += channel.write(block, at);
            }
        } catch (IOException e) {
            throw failed(e);
        }
    }

    private void put(UUID id) {
        block.putLong(id.getMostSignificantBits()).putLong(id.getLeastSignificantBits());
    }

    private static int sum(ByteBuffer block) {
        var crc = new CRC32C();
        crc.update(block.slice(0, BYTES - Integer.BYTES));
        return (int) crc.getValue();
    }

    private static UUID thisBoot() {
        try {
            return UUID.fromString(Files.readString(BOOT).strip());
        } catch (IOException | IllegalArgumentException unknown) {
            return new UUID(0, 0); // no start of the machine is then taken for another one
        }
    }

    private IOException failed(IOException e) {
        return FileTrouble.of(file, "written", e);
    }
}
