// SPDX-License-Identifier: Apache-2.0
package reve.worlds.picture;

import reve.core.disk.WholeFile;
import reve.worlds.render.PixelLayers;

import java.awt.Color;
import java.awt.image.BufferedImage;
import java.awt.image.DataBufferUShort;
import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.Locale;
import java.util.Map;
import java.util.TreeSet;

import javax.imageio.ImageIO;
import javax.imageio.stream.MemoryCacheImageOutputStream;

/**
 * Files of the layers of a picture. PNG files are for people; files in NumPy's format contain the
 * exact numbers.
 */
public final class LayerFiles {
    /** Ending of the names of files in NumPy's format. */
    public static final String NUMPY = ".npy";

    /** Ending of the names of pictures. */
    public static final String PNG = ".png";

    private static final int GREATEST_GREY = 65_535;
    private static final double GOLDEN = 0.6180339887498949;
    private static final int NUMPY_ALIGNMENT = 64;
    private static final int NUMPY_HEAD_BYTES = 10;

    private LayerFiles() {}

    /** Returns the colours of a picture as an image. */
    public static BufferedImage colour(PixelLayers layers) {
        ByteBuffer rgb = layers.colour().orElseThrow();
        var image = new BufferedImage(layers.width(), layers.height(), BufferedImage.TYPE_INT_RGB);
        for (int i = 0; i < layers.width() * layers.height(); i++) {
            image.setRGB(
                    i % layers.width(),
                    i / layers.width(),
                    (rgb.get(3 * i) & 0xff) << 16
                            | (rgb.get(3 * i + 1) & 0xff) << 8
                            | rgb.get(3 * i + 2) & 0xff);
        }
        return image;
    }

    /**
     * Writes the distances along the view direction. A file in NumPy's format contains (height x
     * width) f32 [m]. A PNG contains 16-bit grey values. One step of grey is a power of ten [m]. It
     * is the smallest one with which the distance of the farthest surface fits into 16 bits. The
     * value 0 means that there is no surface.
     *
     * @return the length of a step of the PNG [m]; 1 for NumPy's format
     * @throws IOException if the file cannot be written
     */
    public static double writeDepth(PixelLayers layers, Path file) throws IOException {
        ByteBuffer depth = layers.depth().orElseThrow();
        if (isNumpy(file)) {
            writeNumpy(layers, depth, "<f4", file);
            return 1;
        }
        int count = layers.width() * layers.height();
        double farthest = 0;
        for (int i = 0; i < count; i++) {
            farthest = Math.max(farthest, depth.getFloat(4 * i));
        }
        int exponent = farthest > 0 ? (int) Math.ceil(Math.log10(farthest / GREATEST_GREY)) : 0;
        double step = Double.parseDouble("1e" + exponent);
        var image =
                new BufferedImage(layers.width(), layers.height(), BufferedImage.TYPE_USHORT_GRAY);
        short[] grey = ((DataBufferUShort) image.getRaster().getDataBuffer()).getData();
        for (int i = 0; i < count; i++) {
            float metres = depth.getFloat(4 * i);
            // A surface nearer than half a step is written as 1, because 0 means no surface.
            long steps = metres > 0 ? Math.max(1, Math.round(metres / step)) : 0;
            grey[i] = (short) Math.min(GREATEST_GREY, steps);
        }
        writePng(image, file);
        return step;
    }

    /**
     * Writes the item that each pixel shows. A file in NumPy's format contains the ids of the items
     * as (height x width) u32. A PNG has one colour for each item. The id 0 and black mean no item.
     *
     * @return the ids of the visible items, in ascending order, with their colours as {@code
     *     #rrggbb}
     * @throws IOException if the file cannot be written
     */
    public static Map<Long, String> writeSegmentation(PixelLayers layers, Path file)
            throws IOException {
        ByteBuffer item = layers.item().orElseThrow();
        var ids = new TreeSet<Long>();
        var image = new BufferedImage(layers.width(), layers.height(), BufferedImage.TYPE_INT_RGB);
        for (int i = 0; i < layers.width() * layers.height(); i++) {
            long id = Integer.toUnsignedLong(item.getInt(4 * i));
            if (id != 0) {
                ids.add(id);
                image.setRGB(i % layers.width(), i / layers.width(), rgb(id));
            }
        }
        if (isNumpy(file)) {
            writeNumpy(layers, item, "<u4", file);
        } else {
            writePng(image, file);
        }
        Map<Long, String> colours = new LinkedHashMap<>();
        ids.forEach(id -> colours.put(id, String.format(Locale.ROOT, "#%06x", rgb(id))));
        return colours;
    }

    /** Returns a colour for an id. It differs from the colours of the neighbouring ids. */
    private static int rgb(long id) {
        float hue = (float) (id * GOLDEN % 1);
        float brightness = 1 - 0.2f * (id / 8 % 3);
        return Color.HSBtoRGB(hue, 0.75f, brightness) & 0xffffff;
    }

    private static boolean isNumpy(Path file) {
        return file.toString().toLowerCase(Locale.ROOT).endsWith(NUMPY);
    }

    private static void writeNumpy(PixelLayers layers, ByteBuffer content, String type, Path file)
            throws IOException {
        String description =
                String.format(
                        Locale.ROOT,
                        "{'descr': '%s', 'fortran_order': False, 'shape': (%d, %d), }",
                        type,
                        layers.height(),
                        layers.width());
        int length = NUMPY_HEAD_BYTES + description.length() + 1;
        int rest = Math.floorMod(-length, NUMPY_ALIGNMENT);
        byte[] head = (description + " ".repeat(rest) + "\n").getBytes(StandardCharsets.US_ASCII);
        byte[] bytes = new byte[content.remaining()];
        content.get(content.position(), bytes);
        WholeFile.write(
                file,
                out -> {
                    out.write(new byte[] {(byte) 0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0});
                    out.write(new byte[] {(byte) head.length, (byte) (head.length >> 8)});
                    out.write(head);
                    out.write(bytes);
                });
    }

    /**
     * Writes a picture as a PNG file. An older file at the place stays as it is if the write fails.
     *
     * @throws IOException naming the file and the reason
     */
    public static void writePng(BufferedImage picture, Path file) throws IOException {
        // The encoder would otherwise use a temporary file, and could neither be used while the
        // process ends nor on a full disk.
        try (var png = new ByteArrayOutputStream();
                var encoded = new MemoryCacheImageOutputStream(png)) {
            ImageIO.write(picture, "png", encoded);
            encoded.flush();
            WholeFile.write(file, png::writeTo);
        }
    }
}
