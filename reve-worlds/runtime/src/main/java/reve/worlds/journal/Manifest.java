// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.image.CorruptException;

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
 * The file STORE-manifest. It lists the minimum content of the other files of a store. One small
 * write updates the manifest in place after each frame and each image. The manifest therefore never
 * lists data that is not yet written. Data was lost if the files contain less than the manifest
 * lists. The store writes the name of each file of frames to the manifest before it writes a frame
 * to the file. It flushes the manifest before it commits the image that begins the file. Therefore
 * a manifest that does not name the newest file of frames is an older copy. An older copy does not
 * show whether the newest frames are complete. For any thread.
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
     * The content of a manifest.
     *
     * @param store identity of the store
     * @param boot identity of the machine's boot during which the manifest was written
     * @param file number of the newest file of frames
     * @param fileId identity of that file
     * @param frame last written frame, or frame of the last written image
     * @param image number of the newest image; 0 if there is none
     * @param imageFrame frame of that image
     * @param imageSum checksum of that image
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

        /**
         * Returns whether the machine was booted again after the manifest was written. If so, a
         * power failure may have lost frames.
         */
        boolean isOfAnotherBoot() {
            return !boot.equals(thisBoot());
        }
    }

    /**
     * Opens or creates the manifest, and writes the claim.
     *
     * @throws IOException naming the file and the reason
     */
    Manifest(Path store, Claim claim) throws IOException {
        file = path(store);
        this.claim = claim;
        // Only a regular file is opened, because opening a pipe would block until another process
        // reads from it.
        if (Files.exists(file) && !Files.isRegularFile(file)) {
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
     * Returns the claim of a store's manifest; empty if the manifest is missing or empty.
     *
     * @throws CorruptException if it is damaged or not a manifest
     */
    static Optional<Claim> read(Path store) throws IOException {
        Path file = path(store);
        Optional<String> reason = FileTrouble.noFile(file);
        if (reason.isPresent()) {
            throw new CorruptException(reason.get());
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

    /** Records that another file of frames has begun. */
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

    /** Records that a frame was written. */
    synchronized void reach(long newest) throws IOException {
        frame = newest;
        block.putLong(FRAME_AT, newest);
        write();
    }

    /** Records that an image was written. */
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

    /** Flushes the manifest to the disk, so that it survives a power failure. */
    void force() throws IOException {
        try {
            channel.force(false);
        } catch (IOException e) {
            throw failed(e);
        }
    }

    /** Returns a message if the file was moved, removed or truncated; empty otherwise. */
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
            // The identity of the boot is unknown. The constant identity never counts as the
            // identity of another boot.
            return new UUID(0, 0);
        }
    }

    private IOException failed(IOException e) {
        return FileTrouble.of(file, "written", e);
    }
}
