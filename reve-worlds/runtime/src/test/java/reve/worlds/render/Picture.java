// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import java.awt.image.BufferedImage;
import java.io.ByteArrayInputStream;
import java.io.IOException;
import java.io.UncheckedIOException;
import java.util.function.IntPredicate;

import javax.imageio.ImageIO;

/** A decoded PNG. */
record Picture(BufferedImage image) {

    static Picture decode(byte[] png) {
        try {
            return new Picture(ImageIO.read(new ByteArrayInputStream(png)));
        } catch (IOException broken) {
            throw new UncheckedIOException(broken);
        }
    }

    /** 0xrrggbb. */
    int at(int x, int y) {
        return image.getRGB(x, y) & 0xffffff;
    }

    long count(IntPredicate colour) {
        return java.util.stream.IntStream.range(0, image.getWidth() * image.getHeight())
                .map(i -> at(i % image.getWidth(), i / image.getWidth()))
                .filter(colour)
                .count();
    }
}
