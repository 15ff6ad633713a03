// SPDX-License-Identifier: Apache-2.0
package reve.worlds.plot;

import org.knowm.xchart.XYChart;
import org.knowm.xchart.XYChartBuilder;
import org.knowm.xchart.style.Styler;
import org.knowm.xchart.style.theme.MatlabTheme;

import reve.worlds.picture.LayerFiles;

import java.awt.Graphics2D;
import java.awt.image.BufferedImage;
import java.io.IOException;
import java.nio.file.Path;

/** Charts of one style, as PNG files. They need fonts but no display. */
public final class Charts {
    private static final int WIDTH = 800;
    private static final int HEIGHT = 500;

    /** Number of pixels for each unit of width, height and other sizes in this class. */
    private static final int SCALE = 2;

    private Charts() {}

    /** Returns an empty chart with a title and the titles of its axes. */
    public static XYChart create(String title, String x, String y) {
        XYChart chart =
                new XYChartBuilder()
                        .width(WIDTH)
                        .height(HEIGHT)
                        .title(title)
                        .xAxisTitle(x)
                        .yAxisTitle(y)
                        .build();
        chart.getStyler().setTheme(new MatlabTheme());
        chart.getStyler().setLegendPosition(Styler.LegendPosition.OutsideE);
        return chart;
    }

    /** Draws a chart into a PNG file. */
    public static void write(XYChart chart, Path file) throws IOException {
        var image = new BufferedImage(WIDTH * SCALE, HEIGHT * SCALE, BufferedImage.TYPE_INT_RGB);
        Graphics2D graphics = image.createGraphics();
        try {
            graphics.scale(SCALE, SCALE);
            chart.paint(graphics, WIDTH, HEIGHT);
        } finally {
            graphics.dispose();
        }
        LayerFiles.writePng(image, file);
    }
}
