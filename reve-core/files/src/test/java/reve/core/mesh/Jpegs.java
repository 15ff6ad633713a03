// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import java.awt.image.BufferedImage;
import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.util.Arrays;

import javax.imageio.IIOImage;
import javax.imageio.ImageIO;
import javax.imageio.ImageWriteParam;
import javax.imageio.ImageWriter;
import javax.imageio.stream.MemoryCacheImageOutputStream;

/** Progressive JPEG files of any number of scans. */
final class Jpegs {

    private static final int SCAN = 0xda;

    private Jpegs() {}

    /** A square grey image in the scans that the JDK's encoder writes. */
    static byte[] progressive(int side) throws IOException {
        var image = new BufferedImage(side, side, BufferedImage.TYPE_BYTE_GRAY);
        ImageWriter writer = ImageIO.getImageWritersByFormatName("jpeg").next();
        var bytes = new ByteArrayOutputStream();
        try (var out = new MemoryCacheImageOutputStream(bytes)) {
            ImageWriteParam how = writer.getDefaultWriteParam();
            how.setProgressiveMode(ImageWriteParam.MODE_DEFAULT);
            writer.setOutput(out);
            writer.write(null, new IIOImage(image, null, null), how);
        } finally {
            writer.dispose();
        }
        return bytes.toByteArray();
    }

    /**
     * Returns the same image, in which the last scan occurs {@code more} times more. This scan
     * refines all values.
     */
    static byte[] withScans(int side, int more) throws IOException {
        byte[] image = progressive(side);
        byte[] scan = Arrays.copyOfRange(image, lastScan(image), image.length - 2);
        var bytes = new ByteArrayOutputStream(image.length + more * scan.length);
        bytes.write(image, 0, image.length - 2);
        for (int i = 0; i < more; i++) {
            bytes.writeBytes(scan);
        }
        bytes.write(image, image.length - 2, 2);
        return bytes.toByteArray();
    }

    private static int lastScan(byte[] image) {
        int at = image.length - 2;
        while ((image[at] & 0xff) != 0xff || (image[at + 1] & 0xff) != SCAN) {
            at--;
        }
        return at;
    }
}
