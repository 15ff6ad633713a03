// SPDX-License-Identifier: Apache-2.0
package reve.worlds.picture;

import reve.worlds.render.PixelLayers;

import java.awt.Color;
import java.awt.Font;
import java.awt.FontMetrics;
import java.awt.Graphics2D;
import java.awt.Rectangle;
import java.awt.RenderingHints;
import java.awt.image.BufferedImage;
import java.io.IOException;
import java.nio.ByteBuffer;
import java.util.ArrayList;
import java.util.Comparator;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.TreeMap;
import java.util.function.LongFunction;

/** Text and scale bars that are drawn over pictures. It needs fonts but no display. */
public final class Overlay {
    /** Height of a line of text as a fraction of the picture's height. */
    private static final double LINE = 1 / 24.0;

    private static final int SMALLEST_FONT = 9;
    private static final int MOST_LABELS = 60;

    /** Minimum number of visible pixels of an item that gets a label. */
    private static final int FEWEST_PIXELS = 12;

    private static final Color PAPER = new Color(255, 255, 255, 200);
    private static final Color INK = new Color(30, 30, 30);

    private final Font font;

    /**
     * @param height the height of the pictures [px]
     * @throws IOException if the machine has no fonts
     */
    public Overlay(int height) throws IOException {
        System.setProperty("java.awt.headless", "true");
        try {
            int size = Math.max(SMALLEST_FONT, (int) Math.round(height * LINE));
            font = new Font(Font.SANS_SERIF, Font.PLAIN, size);
            var probe = new BufferedImage(1, 1, BufferedImage.TYPE_INT_RGB);
            Graphics2D graphics = probe.createGraphics();
            graphics.getFontMetrics(font).stringWidth("t");
            graphics.dispose();
        } catch (RuntimeException | LinkageError missing) {
            throw new IOException(
                    "text cannot be drawn: "
                            + missing.getMessage()
                            + "; on Debian, install fontconfig and fonts-dejavu-core",
                    missing);
        }
    }

    /** Writes the world time in the lower left corner. */
    public void time(BufferedImage picture, double seconds) {
        Graphics2D graphics = graphics(picture);
        String text = String.format(Locale.ROOT, "t = %.2f s", seconds);
        FontMetrics metrics = graphics.getFontMetrics();
        int margin = metrics.getHeight() / 2;
        label(
                graphics,
                text,
                new Rectangle(
                        margin,
                        picture.getHeight() - margin - metrics.getHeight(),
                        metrics.stringWidth(text) + margin,
                        metrics.getHeight()));
        graphics.dispose();
    }

    /**
     * Draws a scale bar with its length in the lower right corner.
     *
     * @return the length that the bar stands for [m]
     */
    public double scale(BufferedImage picture, double metresPerPixel) {
        ScaleBar bar = ScaleBar.of(metresPerPixel, picture.getWidth());
        Graphics2D graphics = graphics(picture);
        FontMetrics metrics = graphics.getFontMetrics();
        int margin = metrics.getHeight() / 2;
        int length = Math.max(1, (int) Math.round(bar.pixels()));
        int thickness = Math.max(2, metrics.getHeight() / 6);
        int width = Math.max(length, metrics.stringWidth(bar.text())) + 2 * margin;
        var place =
                new Rectangle(
                        picture.getWidth() - margin - width,
                        picture.getHeight() - 2 * margin - metrics.getHeight() - 2 * thickness,
                        width,
                        metrics.getHeight() + margin + 2 * thickness);
        label(
                graphics,
                bar.text(),
                new Rectangle(place.x, place.y, place.width, metrics.getHeight()));
        graphics.setColor(PAPER);
        graphics.fillRect(
                place.x,
                place.y + metrics.getHeight(),
                place.width,
                place.height - metrics.getHeight());
        graphics.setColor(INK);
        int left = place.x + (place.width - length) / 2;
        int top = place.y + metrics.getHeight() + thickness / 2;
        graphics.fillRect(left, top, length, thickness);
        graphics.dispose();
        return bar.metres();
    }

    /**
     * Writes the names of visible items. A label is above the visible part of its item. It is in
     * the middle of this part if there is no room above, or if the part is wider than half of the
     * picture. Larger items come first. A label that would cover another label is omitted.
     *
     * @param layers the layers of the picture, including the items of the pixels
     * @param names returns the name of an item by its id
     */
    public void labels(BufferedImage picture, PixelLayers layers, LongFunction<String> names) {
        Graphics2D graphics = graphics(picture);
        FontMetrics metrics = graphics.getFontMetrics();
        int height = metrics.getHeight();
        List<Rectangle> used = new ArrayList<>();
        for (Seen item : visible(layers)) {
            String name = names.apply(item.id);
            Rectangle seen = item.box(picture.getWidth());
            int width = metrics.stringWidth(name) + height / 2;
            int top = seen.y - height;
            if (top < 0) {
                top = seen.y + (seen.height - height) / 2;
            }
            int left = seen.x + (seen.width - width) / 2;
            left = Math.clamp(left, 0, Math.max(0, picture.getWidth() - width));
            var place = new Rectangle(left, top, width, height);
            if (used.size() < MOST_LABELS && used.stream().noneMatch(place::intersects)) {
                used.add(place);
                label(graphics, name, place);
            }
        }
        graphics.dispose();
    }

    private Graphics2D graphics(BufferedImage picture) {
        Graphics2D graphics = picture.createGraphics();
        graphics.setRenderingHint(
                RenderingHints.KEY_TEXT_ANTIALIASING, RenderingHints.VALUE_TEXT_ANTIALIAS_ON);
        graphics.setFont(font);
        return graphics;
    }

    private static void label(Graphics2D graphics, String text, Rectangle place) {
        FontMetrics metrics = graphics.getFontMetrics();
        graphics.setColor(PAPER);
        graphics.fill(place);
        graphics.setColor(INK);
        graphics.drawString(
                text,
                place.x + (place.width - metrics.stringWidth(text)) / 2,
                place.y + metrics.getAscent());
    }

    /** The pixels of an item. */
    private static final class Seen {
        private final long id;
        private final Rectangle box;
        private int pixels;
        private long sumX;
        private long sumY;

        Seen(long id, int x, int y) {
            this.id = id;
            box = new Rectangle(x, y, 1, 1);
        }

        void add(int x, int y) {
            box.add(new Rectangle(x, y, 1, 1));
            pixels++;
            sumX += x;
            sumY += y;
        }

        int pixels() {
            return pixels;
        }

        /**
         * Returns the box around the pixels. Returns an empty box in the middle if the box is wider
         * than half of the picture.
         */
        Rectangle box(int pictureWidth) {
            return box.width > pictureWidth / 2
                    ? new Rectangle((int) (sumX / pixels), (int) (sumY / pixels), 0, 0)
                    : box;
        }
    }

    /** Returns the visible items. Items with more pixels come first. */
    private static List<Seen> visible(PixelLayers layers) {
        ByteBuffer item = layers.item().orElseThrow();
        Map<Long, Seen> all = new TreeMap<>();
        for (int i = 0; i < layers.width() * layers.height(); i++) {
            long id = Integer.toUnsignedLong(item.getInt(4 * i));
            if (id != 0) {
                int x = i % layers.width();
                int y = i / layers.width();
                all.computeIfAbsent(id, _ -> new Seen(id, x, y)).add(x, y);
            }
        }
        return all.values().stream()
                .filter(seen -> seen.pixels() >= FEWEST_PIXELS)
                .sorted(Comparator.comparingInt(Seen::pixels).reversed())
                .toList();
    }
}
