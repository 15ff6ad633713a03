// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import reve.core.world.Mesh;
import reve.core.world.Relief;

import java.io.ByteArrayInputStream;
import java.io.IOException;
import java.util.Arrays;

import javax.imageio.ImageIO;
import javax.imageio.ImageReader;
import javax.imageio.stream.ImageInputStream;
import javax.imageio.stream.MemoryCacheImageInputStream;

/**
 * A grid of heights from a file: a grey PNG image, or a text of numbers. The first row of the file
 * is the row of the terrain at its -Z edge. Immutable.
 *
 * @param rows at least 2
 * @param columns at least 2
 * @param values (rows x columns) heights [m], or brightness from 0 to 1 if the file is an image
 */
public record HeightGrid(int rows, int columns, float[] values) {
    /** Maximum number of heights, because each cell of the grid becomes two triangles. */
    public static final int MAX_HEIGHTS = Mesh.MAX_COUNT / 2;

    /** Ending of the name of an image, in lower case. */
    static final String IMAGE = ".png";

    /** Ending of the name of a text, in lower case. */
    static final String TEXT = ".txt";

    /** Offsets in a PNG file of the number of bits of a sample, and of the type of its colours. */
    private static final int BITS = 24;

    private static final int COLOURS = 25;
    private static final int GREY = 0;

    /**
     * Reads a grey PNG image with samples of 8 or 16 bits. Checks the size in its header before it
     * allocates memory.
     */
    static HeightGrid ofImage(byte[] bytes, Sources sources) throws AssetException {
        requireGrey(bytes, sources);
        ImageReader reader = ImageIO.getImageReadersByFormatName("png").next();
        try (ImageInputStream in =
                new MemoryCacheImageInputStream(new ByteArrayInputStream(bytes))) {
            reader.setInput(in, true, true);
            int columns = reader.getWidth(0);
            int rows = reader.getHeight(0);
            requireSize(rows, columns, "pixels", sources);
            sources.budget().takePixels(sources.path(), (long) rows * columns);
            int[] samples =
                    reader.read(0).getRaster().getSamples(0, 0, columns, rows, 0, (int[]) null);
            int white = (1 << (bytes[BITS] & 0xff)) - 1;
            float[] values = new float[samples.length];
            for (int i = 0; i < values.length; i++) {
                values[i] = (float) samples[i] / white;
            }
            return new HeightGrid(rows, columns, values);
        } catch (IOException | RuntimeException broken) {
            // The decoder of the JDK throws unchecked exceptions for some malformed files.
            throw new AssetException(
                    sources.path()
                            + ": a broken image: "
                            + Reason.of(broken, "the file contradicts itself"),
                    broken);
        } finally {
            reader.dispose();
        }
    }

    private static void requireGrey(byte[] bytes, Sources sources) throws AssetException {
        boolean png = bytes.length > COLOURS && bytes[0] == (byte) 0x89 && bytes[1] == 'P';
        if (!png) {
            throw sources.refuse("expected a PNG image");
        }
        int bits = bytes[BITS] & 0xff;
        if (bytes[COLOURS] != GREY || bits != 8 && bits != 16) {
            throw sources.refuse(
                    "an image with "
                            + (bytes[COLOURS] == GREY ? bits + " bits for each pixel" : "colours")
                            + ", expected a grey one with 8 or 16 bits for each pixel and no alpha;"
                            + " convert it");
        }
    }

    /**
     * Reads a text: a line of numbers for each row, which spaces separate. A line that begins with
     * {@code #} is a comment.
     */
    static HeightGrid ofText(byte[] bytes, Sources sources) throws AssetException {
        var lines = new ObjLines(bytes, sources, "no terrain");
        float[] values = new float[1024];
        int count = 0;
        int columns = 0;
        int rows = 0;
        while (lines.next()) {
            int before = count;
            do {
                if (count == MAX_HEIGHTS) {
                    throw sources.refuse(
                            "more than " + MAX_HEIGHTS + " numbers; use fewer of them");
                }
                values = count < values.length ? values : Arrays.copyOf(values, 2 * count);
                values[count++] = lines.finite();
            } while (lines.word());
            columns = rows == 0 ? count : columns;
            if (count - before != columns) {
                throw lines.refuse(
                        "found "
                                + (count - before)
                                + " numbers, expected "
                                + columns
                                + " as in the first row");
            }
            rows++;
        }
        requireSize(rows, columns, "numbers", sources);
        return new HeightGrid(rows, columns, Arrays.copyOf(values, count));
    }

    private static void requireSize(int rows, int columns, String what, Sources sources)
            throws AssetException {
        if (rows < 2 || columns < 2 || (long) rows * columns > MAX_HEIGHTS) {
            throw sources.refuse(
                    "has "
                            + columns
                            + " x "
                            + rows
                            + " "
                            + what
                            + ", expected at least 2 x 2 and at most "
                            + MAX_HEIGHTS
                            + " in all, such as 724 x 724; scale it");
        }
    }

    /** Returns the mesh of the terrain, with texture coordinates. */
    Mesh mesh(Relief relief, Sources sources) throws AssetException {
        sources.budget().takeVertices(sources.path(), (long) rows * columns);
        sources.budget().takeTriangles(sources.path(), 2L * (rows - 1) * (columns - 1));
        float[] vertices = new float[3 * rows * columns];
        float[] coordinates = new float[2 * rows * columns];
        for (int at = 0; at < rows * columns; at++) {
            double u = (double) (at % columns) / (columns - 1);
            double v = (double) (at / columns) / (rows - 1);
            vertices[3 * at] = (float) (relief.x() * (u - 0.5));
            vertices[3 * at + 1] = (float) relief.height(values[at]);
            vertices[3 * at + 2] = (float) (relief.z() * (v - 0.5));
            coordinates[2 * at] = (float) u;
            coordinates[2 * at + 1] = (float) v;
        }
        try {
            return Mesh.builder(vertices, Relief.triangles(rows, columns))
                    .textureCoordinates(coordinates)
                    .file(sources.path())
                    .relief(relief)
                    .build();
        } catch (IllegalArgumentException unfit) {
            throw sources.refuse(unfit.getMessage());
        }
    }
}
