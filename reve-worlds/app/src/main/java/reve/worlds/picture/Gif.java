// SPDX-License-Identifier: Apache-2.0
package reve.worlds.picture;

import reve.core.disk.PartFile;

import java.awt.image.BufferedImage;
import java.awt.image.IndexColorModel;
import java.io.BufferedInputStream;
import java.io.BufferedOutputStream;
import java.io.DataInputStream;
import java.io.IOException;
import java.nio.channels.Channels;
import java.nio.channels.FileChannel;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.nio.file.StandardOpenOption;
import java.util.zip.Deflater;
import java.util.zip.DeflaterOutputStream;
import java.util.zip.InflaterInputStream;

import javax.imageio.IIOImage;
import javax.imageio.ImageIO;
import javax.imageio.ImageTypeSpecifier;
import javax.imageio.ImageWriter;
import javax.imageio.metadata.IIOMetadata;
import javax.imageio.metadata.IIOMetadataNode;
import javax.imageio.stream.ImageOutputStream;

/**
 * An animated GIF that repeats for ever. The JDK's encoder writes it. All pictures share one {@link
 * Palette}. The palette is known only after the last picture was added, so the pictures wait in a
 * temporary file. Each picture contains only the box in which it differs from the picture before.
 */
public final class Gif implements FrameSink {
    private static final String FORMAT = "javax_imageio_gif_image_1.0";
    private static final int TRANSPARENT = Palette.SIZE;
    private static final int HUNDREDTHS = 100;
    private static final int BUFFER_BYTES = 1 << 16;

    private final Path place;
    private final Path part;
    private final FileChannel waiting;
    private final int fps;
    private final Palette.Histogram histogram = new Palette.Histogram();
    private final Deflater fast;
    private final DeflaterOutputStream spool;
    private int width;
    private int height;
    private int count;
    private boolean finished;

    /**
     * @param fps pictures per second, 1 to 50; the format states times in hundredths of a second
     * @throws IOException if the temporary file cannot be created
     */
    public Gif(Path place, int fps) throws IOException {
        this.place = place;
        this.fps = fps;
        part = PartFile.create(place);
        Path file = Files.createTempFile("reve-gif", ".rgb");
        // The option deletes the file when it is closed. On Linux the file has no name after it was
        // opened, so a killed process leaves no file.
        waiting =
                FileChannel.open(
                        file,
                        StandardOpenOption.READ,
                        StandardOpenOption.WRITE,
                        StandardOpenOption.DELETE_ON_CLOSE);
        fast = new Deflater(Deflater.BEST_SPEED);
        spool =
                new DeflaterOutputStream(
                        new BufferedOutputStream(Channels.newOutputStream(waiting)),
                        fast,
                        BUFFER_BYTES);
    }

    @Override
    public void add(BufferedImage picture) throws IOException {
        width = picture.getWidth();
        height = picture.getHeight();
        int[] rgb = picture.getRGB(0, 0, width, height, null, 0, width);
        byte[] bytes = new byte[3 * rgb.length];
        for (int i = 0; i < rgb.length; i++) {
            histogram.add(rgb[i]);
            bytes[3 * i] = (byte) (rgb[i] >> 16);
            bytes[3 * i + 1] = (byte) (rgb[i] >> 8);
            bytes[3 * i + 2] = (byte) rgb[i];
        }
        spool.write(bytes);
        count++;
    }

    @Override
    public void finish() throws IOException {
        spool.finish();
        spool.flush();
        waiting.position(0);
        var palette = new Palette(histogram);
        ImageWriter writer = ImageIO.getImageWritersByFormatName("gif").next();
        try (var in =
                        new DataInputStream(
                                new InflaterInputStream(
                                        new BufferedInputStream(
                                                Channels.newInputStream(waiting))));
                ImageOutputStream out = ImageIO.createImageOutputStream(part.toFile())) {
            writer.setOutput(out);
            writer.prepareWriteSequence(null);
            byte[] rgb = new byte[3 * width * height];
            byte[] last = new byte[0];
            for (int number = 0; number < count; number++) {
                in.readFully(rgb);
                byte[] now = palette.indices(rgb, width);
                write(writer, palette, last, now, number);
                last = now;
            }
            writer.endWriteSequence();
        } finally {
            writer.dispose();
        }
        PartFile.move(part, place, StandardCopyOption.REPLACE_EXISTING);
        finished = true;
    }

    private void write(ImageWriter writer, Palette palette, byte[] last, byte[] now, int number)
            throws IOException {
        int left = width;
        int right = -1;
        int top = height;
        int bottom = -1;
        for (int i = 0; i < now.length; i++) {
            if (last.length == 0 || now[i] != last[i]) {
                left = Math.min(left, i % width);
                right = Math.max(right, i % width);
                top = Math.min(top, i / width);
                bottom = Math.max(bottom, i / width);
            }
        }
        if (right < 0) {
            // No pixel differs, so a single pixel is written again.
            left = 0;
            right = 0;
            top = 0;
            bottom = 0;
        }
        IndexColorModel colours = palette.colours();
        var box =
                new BufferedImage(
                        right - left + 1,
                        bottom - top + 1,
                        BufferedImage.TYPE_BYTE_INDEXED,
                        colours);
        for (int y = top; y <= bottom; y++) {
            for (int x = left; x <= right; x++) {
                int i = y * width + x;
                boolean same = last.length > 0 && now[i] == last[i];
                box.getRaster().setSample(x - left, y - top, 0, same ? TRANSPARENT : now[i] & 0xff);
            }
        }
        IIOMetadata metadata = writer.getDefaultImageMetadata(new ImageTypeSpecifier(box), null);
        metadata.mergeTree(FORMAT, tree(left, top, box, number));
        writer.writeToSequence(new IIOImage(box, null, metadata), null);
    }

    private IIOMetadataNode tree(int left, int top, BufferedImage box, int number) {
        var root = new IIOMetadataNode(FORMAT);
        var descriptor = child(root, "ImageDescriptor");
        descriptor.setAttribute("imageLeftPosition", Integer.toString(left));
        descriptor.setAttribute("imageTopPosition", Integer.toString(top));
        descriptor.setAttribute("imageWidth", Integer.toString(box.getWidth()));
        descriptor.setAttribute("imageHeight", Integer.toString(box.getHeight()));
        descriptor.setAttribute("interlaceFlag", "FALSE");
        var control = child(root, "GraphicControlExtension");
        control.setAttribute("disposalMethod", "doNotDispose");
        control.setAttribute("userInputFlag", "FALSE");
        control.setAttribute("transparentColorFlag", "TRUE");
        control.setAttribute("transparentColorIndex", Integer.toString(TRANSPARENT));
        // Each delay is the difference of two rounded times. The sum of the delays therefore stays
        // correct even if the exact delay is no whole number.
        int delay = HUNDREDTHS * (number + 1) / fps - HUNDREDTHS * number / fps;
        control.setAttribute("delayTime", Integer.toString(delay));
        if (number == 0) {
            var repeat = child(child(root, "ApplicationExtensions"), "ApplicationExtension");
            repeat.setAttribute("applicationID", "NETSCAPE");
            repeat.setAttribute("authenticationCode", "2.0");
            repeat.setUserObject(new byte[] {1, 0, 0});
        }
        return root;
    }

    private static IIOMetadataNode child(IIOMetadataNode parent, String name) {
        var child = new IIOMetadataNode(name);
        parent.appendChild(child);
        return child;
    }

    @Override
    public void close() throws IOException {
        waiting.close();
        fast.end();
        if (!finished) {
            PartFile.remove(part);
        }
    }
}
