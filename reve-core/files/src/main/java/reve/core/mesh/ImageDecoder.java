// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import reve.core.world.Texture;

import java.awt.color.ColorSpace;
import java.awt.image.BufferedImage;
import java.awt.image.DataBuffer;
import java.awt.image.Raster;
import java.io.ByteArrayInputStream;
import java.io.IOException;
import java.util.Optional;

import javax.imageio.ImageIO;
import javax.imageio.ImageReader;
import javax.imageio.stream.ImageInputStream;
import javax.imageio.stream.MemoryCacheImageInputStream;

/**
 * Decoder of PNG and JPEG files. It reads the header first, because a small file can contain a huge
 * image.
 */
final class ImageDecoder {

    /** Maximum number of scans of a JPEG image. Encoders write about ten. */
    private static final int MAX_SCANS = 64;

    private static final int TEM = 0x01;
    private static final int RST0 = 0xd0;
    private static final int SOI = 0xd8;
    private static final int EOI = 0xd9;
    private static final int SOS = 0xda;

    private ImageDecoder() {}

    /**
     * Decodes an image.
     *
     * @param name name of the image for messages
     * @param file value for {@link Texture#file}
     */
    static Texture decode(byte[] bytes, String name, Optional<String> file, Budget budget)
            throws AssetException {
        String format = format(bytes, name);
        if (format.equals("jpeg")) {
            requireFewScans(bytes, name);
        }
        ImageReader reader = ImageIO.getImageReadersByFormatName(format).next();
        try (ImageInputStream in =
                new MemoryCacheImageInputStream(new ByteArrayInputStream(bytes))) {
            reader.setInput(in, true, true);
            int width = reader.getWidth(0);
            int height = reader.getHeight(0);
            if (!Texture.fits(width, height)) {
                throw new AssetException(
                        name
                                + ": an image of "
                                + width
                                + " x "
                                + height
                                + " pixels, at most "
                                + Texture.MAX_SIDE
                                + " a side and "
                                + Texture.MAX_PIXELS
                                + " in all are allowed");
            }
            budget.takePixels(name, (long) width * height);
            return new Texture(width, height, rgba(reader.read(0)), file);
        } catch (IOException | RuntimeException broken) {
            // The decoders of the JDK throw unchecked exceptions for some malformed files. They are
            // reported like other errors of a file.
            throw new AssetException(
                    name + ": a broken image: " + Reason.of(broken, "the file contradicts itself"),
                    broken);
        } finally {
            reader.dispose();
        }
    }

    /**
     * Limits the number of scans of a JPEG image, because a scan of a few bytes can make the
     * decoder pass over all pixels.
     */
    private static void requireFewScans(byte[] bytes, String name) throws AssetException {
        int scans = 0;
        int at = 2;
        while (at + 3 < bytes.length) {
            int marker = bytes[at + 1] & 0xff;
            if (bytes[at] != (byte) 0xff
                    || marker <= TEM
                    || marker == 0xff
                    || marker >= RST0 && marker <= SOI) {
                // The byte is data of a scan, lies between segments, or is a marker without a
                // segment.
                at++;
            } else if (marker == EOI) {
                return;
            } else {
                scans += marker == SOS ? 1 : 0;
                at += 2 + ((bytes[at + 2] & 0xff) << 8 | bytes[at + 3] & 0xff);
            }
            if (scans > MAX_SCANS) {
                throw new AssetException(
                        name
                                + ": a JPEG of more than "
                                + MAX_SCANS
                                + " scans; save it again with fewer, or as PNG");
            }
        }
    }

    private static String format(byte[] bytes, String name) throws AssetException {
        if (bytes.length > 8 && bytes[0] == (byte) 0x89 && bytes[1] == 'P' && bytes[2] == 'N') {
            return "png";
        }
        if (bytes.length > 8 && bytes[0] == (byte) 0xff && bytes[1] == (byte) 0xd8) {
            return "jpeg";
        }
        throw new AssetException(name + ": expected a PNG or JPEG image");
    }

    private static byte[] rgba(BufferedImage image) {
        int width = image.getWidth();
        int height = image.getHeight();
        byte[] pixels = new byte[4 * width * height];
        // Grey images need their own conversion. Java treats grey values as linear light, but image
        // files store them as sRGB, like colours.
        boolean grey = image.getColorModel().getColorSpace().getType() == ColorSpace.TYPE_GRAY;
        int[] row = new int[width];
        for (int y = 0; y < height; y++) {
            if (grey) {
                greyRow(image.getRaster(), y, row);
            } else {
                image.getRGB(0, y, width, 1, row, 0, width);
            }
            for (int x = 0, at = 4 * width * y; x < width; x++) {
                pixels[at++] = (byte) (row[x] >> 16);
                pixels[at++] = (byte) (row[x] >> 8);
                pixels[at++] = (byte) row[x];
                pixels[at++] = (byte) 255;
            }
        }
        return pixels;
    }

    private static void greyRow(Raster raster, int y, int[] row) {
        raster.getSamples(0, y, row.length, 1, 0, row);
        int shift = raster.getDataBuffer().getDataType() == DataBuffer.TYPE_USHORT ? 8 : 0;
        for (int x = 0; x < row.length; x++) {
            row[x] = (row[x] >> shift) * 0x010101;
        }
    }
}
