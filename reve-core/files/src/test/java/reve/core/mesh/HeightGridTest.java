// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.world.Mesh;
import reve.core.world.Relief;

import java.awt.image.BufferedImage;
import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;
import java.util.Optional;
import java.util.Random;

import javax.imageio.ImageIO;

/** Terrains whose heights are in files. */
class HeightGridTest {
    private static final Relief HILL = new Relief(6, 4, Optional.of(new Relief.Range(-1, 3)));
    private static final Relief PLAIN = new Relief(6, 4, Optional.empty());

    @TempDir Path folder = Path.of("");

    private Assets assets() {
        return new Assets(new WorldFolder(folder));
    }

    private static BufferedImage grey(int type, int columns, int rows, Random random) {
        var image = new BufferedImage(columns, rows, type);
        int bits = type == BufferedImage.TYPE_USHORT_GRAY ? 16 : 8;
        for (int y = 0; y < rows; y++) {
            for (int x = 0; x < columns; x++) {
                image.getRaster().setSample(x, y, 0, random.nextInt(1 << bits));
            }
        }
        return image;
    }

    private void save(BufferedImage image, String name) throws IOException {
        assertThat(ImageIO.write(image, "png", folder.resolve(name).toFile())).isTrue();
    }

    /** The brightness of each pixel determines a height: -1 m + 4 m s / s_max. */
    @ParameterizedTest
    @ValueSource(ints = {BufferedImage.TYPE_BYTE_GRAY, BufferedImage.TYPE_USHORT_GRAY})
    void theBrightnessOfEachPixelIsAHeight(int type) throws Exception {
        BufferedImage image = grey(type, 5, 3, new Random(1));
        image.getRaster().setSample(0, 0, 0, 0);
        int white = type == BufferedImage.TYPE_USHORT_GRAY ? 65535 : 255;
        image.getRaster().setSample(4, 2, 0, white);
        save(image, "hill.png");
        Mesh mesh = assets().terrain("hill.png", HILL);
        for (int row = 0; row < 3; row++) {
            for (int column = 0; column < 5; column++) {
                int at = 3 * (5 * row + column);
                double height = -1 + 4.0 * image.getRaster().getSample(column, row, 0) / white;
                assertThat(mesh.vertices().get(at)).isEqualTo((float) (1.5 * column - 3));
                assertThat((double) mesh.vertices().get(at + 1)).isCloseTo(height, within(1e-6));
                assertThat(mesh.vertices().get(at + 2)).isEqualTo(2f * row - 2);
            }
        }
        assertThat(mesh.min(1)).isEqualTo(-1);
        assertThat(mesh.max(1)).isEqualTo(3);
        assertThat(mesh.triangles().remaining() / 3).isEqualTo(16);
        assertThat(mesh.file()).contains("hill.png");
        assertThat(mesh.relief()).contains(HILL);
        assertThat(mesh.textureCoordinates().orElseThrow().get(2 * 14)).isEqualTo(1);
        assertThat(mesh.textureCoordinates().orElseThrow().get(2 * 14 + 1)).isEqualTo(1);
    }

    @Test
    void aTextHasALineOfHeightsForEachRow() throws Exception {
        Files.writeString(
                folder.resolve("dale.TXT"), "# a dale\n0.5 1e-3 -2\n\n\t0  0.25\t7.5 \r\n");
        Mesh mesh = assets().terrain("dale.TXT", PLAIN);
        float[] heights = new float[6];
        for (int i = 0; i < heights.length; i++) {
            heights[i] = mesh.vertices().get(3 * i + 1);
        }
        assertThat(heights).containsExactly(0.5f, 1e-3f, -2, 0, 0.25f, 7.5f);
    }

    /** All triangles face upwards, and their shadows fill the rectangle exactly once. */
    @Test
    void theTrianglesCoverTheRectangle() throws Exception {
        save(grey(BufferedImage.TYPE_USHORT_GRAY, 17, 9, new Random(2)), "hill.png");
        Mesh mesh = assets().terrain("hill.png", HILL);
        double area = 0;
        for (int i = 0; i < mesh.triangles().remaining(); i += 3) {
            double[] x = new double[3];
            double[] z = new double[3];
            for (int corner = 0; corner < 3; corner++) {
                int at = 3 * mesh.triangles().get(i + corner);
                x[corner] = mesh.vertices().get(at);
                z[corner] = mesh.vertices().get(at + 2);
            }
            double upwards = (z[1] - z[0]) * (x[2] - x[0]) - (x[1] - x[0]) * (z[2] - z[0]);
            assertThat(upwards).isPositive();
            area += upwards / 2;
        }
        assertThat(area).isCloseTo(24, within(1e-5));
    }

    @Test
    void itemsWithTheSameMeasuresShareTheMesh() throws Exception {
        save(grey(BufferedImage.TYPE_BYTE_GRAY, 4, 4, new Random(3)), "hill.png");
        Files.createSymbolicLink(folder.resolve("link.png"), Path.of("hill.png"));
        var assets = assets();
        Mesh mesh = assets.terrain("hill.png", HILL);
        assertThat(assets.terrain("link.png", HILL)).isSameAs(mesh);
        var lower = new Relief(6, 4, Optional.of(new Relief.Range(-1, 2)));
        assertThat(assets.terrain("hill.png", lower).max(1)).isLessThan(2.0 + 1e-6);
        assertThat(assets.terrain("hill.png", lower)).isNotSameAs(mesh);
    }

    @ParameterizedTest(name = "{index}: {0}")
    @CsvSource(
            delimiter = '!',
            quoteCharacter = '\'',
            textBlock =
                    """
                    ''             ! a.txt: has 0 x 0 numbers, expected at least 2 x 2 and at most 524288 in all, such as 724 x 724; scale it
                    1 2 3          ! a.txt: has 3 x 1 numbers, expected at least 2 x 2
                    1|2|3          ! a.txt: has 1 x 3 numbers, expected at least 2 x 2
                    1 2|3          ! a.txt: no terrain: line 2: found 1 numbers, expected 2 as in the first row
                    1 2||# x|3 4 5 ! a.txt: no terrain: line 4: found 3 numbers, expected 2 as in the first row
                    1 2|3 four     ! a.txt: no terrain: line 2: `four` is no number
                    1,5 2|3 4      ! a.txt: no terrain: line 1: `1,5` is no number
                    1 2|NaN 4      ! a.txt: no terrain: line 2: `NaN` is no finite 32-bit number
                    1 2|3 1e39     ! a.txt: no terrain: line 2: `1e39` is no finite 32-bit number
                    """)
    void aWrongTextIsRefused(String text, String message) throws IOException {
        Files.writeString(folder.resolve("a.txt"), text.replace('|', '\n'));
        assertThatThrownBy(() -> assets().terrain("a.txt", PLAIN))
                .isInstanceOf(AssetException.class)
                .hasMessageStartingWith(message);
    }

    @Test
    void aTextWithTooManyNumbersIsRefusedBeforeItsEnd() throws IOException {
        String row = "0 ".repeat(1024) + "\n";
        Files.writeString(folder.resolve("a.txt"), row.repeat(513) + "no number");
        assertThatThrownBy(() -> assets().terrain("a.txt", PLAIN))
                .hasMessage("a.txt: more than 524288 numbers; use fewer of them");
    }

    @ParameterizedTest
    @CsvSource({
        BufferedImage.TYPE_INT_RGB + ", an image with colours",
        BufferedImage.TYPE_INT_ARGB + ", an image with colours",
        BufferedImage.TYPE_BYTE_BINARY + ", an image with"
    })
    void onlyGreyImagesWith8Or16BitsAreHeights(int type, String found) throws IOException {
        save(new BufferedImage(4, 4, type), "a.png");
        assertThatThrownBy(() -> assets().terrain("a.png", HILL))
                .hasMessageStartingWith("a.png: " + found)
                .hasMessageEndingWith(
                        ", expected a grey one with 8 or 16 bits for each pixel and no alpha;"
                                + " convert it");
    }

    @Test
    void anImageThatIsTooLargeOrTooSmallOrBrokenIsRefused() throws IOException {
        save(new BufferedImage(1024, 513, BufferedImage.TYPE_BYTE_GRAY), "large.png");
        assertThatThrownBy(() -> assets().terrain("large.png", HILL))
                .hasMessage(
                        "large.png: has 1024 x 513 pixels, expected at least 2 x 2 and at most"
                                + " 524288 in all, such as 724 x 724; scale it");
        save(new BufferedImage(1, 5, BufferedImage.TYPE_BYTE_GRAY), "small.png");
        assertThatThrownBy(() -> assets().terrain("small.png", HILL))
                .hasMessageStartingWith("small.png: has 1 x 5 pixels, expected at least 2 x 2");
        save(grey(BufferedImage.TYPE_USHORT_GRAY, 64, 64, new Random(4)), "whole.png");
        byte[] whole = Files.readAllBytes(folder.resolve("whole.png"));
        Files.write(folder.resolve("cut.png"), Arrays.copyOf(whole, whole.length / 2));
        assertThatThrownBy(() -> assets().terrain("cut.png", HILL))
                .hasMessageStartingWith("cut.png: a broken image: ");
        Files.writeString(folder.resolve("text.png"), "this is a text and no image at all");
        assertThatThrownBy(() -> assets().terrain("text.png", HILL))
                .hasMessage("text.png: expected a PNG image");
        assertThatThrownBy(() -> assets().terrain("hill.jpg", HILL))
                .hasMessage("hill.jpg: there is no such file in the world's folder");
        Files.writeString(folder.resolve("hill.csv"), "0 0\n0 0\n");
        assertThatThrownBy(() -> assets().terrain("hill.csv", PLAIN))
                .hasMessage(
                        "hill.csv: expected heights in a grey .png image or a .txt file of"
                                + " numbers; convert it");
    }

    /** Each mesh counts, also if several are made from one file. */
    @Test
    void terrainsCountInTheLimitsOfTheWorld() throws Exception {
        Files.writeString(folder.resolve("a.txt"), "0 0\n0 0\n");
        var budget = new Budget(System::nanoTime);
        budget.begin();
        budget.takeVertices("b.obj", Budget.MAX_VERTICES - 8);
        var assets = new Assets(new WorldFolder(folder), budget);
        assets.terrain("a.txt", PLAIN);
        assets.terrain("a.txt", PLAIN);
        assets.terrain("a.txt", new Relief(6, 5, Optional.empty()));
        assertThatThrownBy(() -> assets.terrain("a.txt", new Relief(6, 6, Optional.empty())))
                .hasMessage(
                        "a.txt: the meshes of this world have more than 4194304 vertices together");
    }
}
