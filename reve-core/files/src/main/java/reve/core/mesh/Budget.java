// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import java.util.function.LongSupplier;

/** Limits on the time and size of all assets of one world together. For one thread. */
final class Budget {

    static final long MAX_BYTES = 1L << 28;
    static final long MAX_VERTICES = 1 << 22;
    static final long MAX_TRIANGLES = 1 << 22;
    static final long MAX_PIXELS = 1 << 25;

    /**
     * Maximum time to read all assets of a world [s]. One of the size limits is normally reached
     * much earlier.
     */
    static final long MAX_SECONDS = 60;

    private final LongSupplier nanoTime;
    private long bytes;
    private long vertices;
    private long triangles;
    private long pixels;
    private long nanoseconds;
    private long begun;

    /**
     * @param nanoTime a clock like {@link System#nanoTime}
     */
    Budget(LongSupplier nanoTime) {
        this.nanoTime = nanoTime;
    }

    /** Starts the clock. Called before an asset is read. */
    void begin() {
        begun = nanoTime.getAsLong();
    }

    /** Stops the clock. Called after an asset was read. */
    void end() {
        nanoseconds += nanoTime.getAsLong() - begun;
    }

    /**
     * Counts the size of a file. Data that is read twice from the inside of a file counts twice.
     * Throws an exception if the limit is exceeded.
     */
    void takeBytes(String path, long count) throws AssetException {
        bytes += count;
        require(path, bytes, MAX_BYTES, "meshes and images", "bytes");
    }

    void takeVertices(String path, long count) throws AssetException {
        vertices += count;
        require(path, vertices, MAX_VERTICES, "meshes", "vertices");
    }

    void takeTriangles(String path, long count) throws AssetException {
        triangles += count;
        require(path, triangles, MAX_TRIANGLES, "meshes", "triangles");
    }

    void takePixels(String path, long count) throws AssetException {
        pixels += count;
        require(path, pixels, MAX_PIXELS, "textures", "pixels");
    }

    private void require(String path, long taken, long most, String assets, String what)
            throws AssetException {
        if (taken > most) {
            throw new AssetException(
                    path
                            + ": the "
                            + assets
                            + " of this world have more than "
                            + most
                            + " "
                            + what
                            + " together");
        }
        if (nanoseconds + nanoTime.getAsLong() - begun > MAX_SECONDS * 1_000_000_000) {
            throw new AssetException(
                    path
                            + ": the meshes and images of this world take longer "
                            + "than "
                            + MAX_SECONDS
                            + " s to read; use fewer or smaller ones");
        }
    }
}
