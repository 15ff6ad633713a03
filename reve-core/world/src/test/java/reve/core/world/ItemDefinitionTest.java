// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import java.util.Collections;
import java.util.List;

class ItemDefinitionTest {

    @ParameterizedTest
    @ValueSource(strings = {"", "  ", "a\nb", "tab\there", "\u0000", "del\u007f"})
    void refusesNamesThatCannotBeRead(String name) {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ItemDefinition.named(name))
                .withMessageContaining("item name");
    }

    @Test
    void acceptsNamesUpTo128CharactersAndNoMore() {
        assertThat(ItemDefinition.named("x".repeat(128)).build().name()).hasSize(128);
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ItemDefinition.named("x".repeat(129)))
                .withMessageContaining("129 characters")
                .withMessageContaining("at most 128");
    }

    @ParameterizedTest
    @ValueSource(doubles = {Double.NaN, Double.POSITIVE_INFINITY, Double.NEGATIVE_INFINITY})
    void refusesNumbersThatAreNotFiniteWhereverTheyAreGiven(double bad) {
        var ball = ItemDefinition.named("ball");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.at(0, bad, 0))
                .withMessageContaining("item ball: position")
                .withMessageContaining("" + bad);
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.orientation(0, 0, 0, bad))
                .withMessageContaining("item ball: orientation")
                .withMessageContaining("" + bad);
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.physics("mass", bad))
                .withMessage("item ball: mass is " + bad + ", expected finite numbers");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.symbol("heat", bad))
                .withMessageContaining("item ball: heat")
                .withMessageContaining("" + bad);
        assertThatIllegalArgumentException().isThrownBy(() -> Shape.sphere(bad));
        assertThatIllegalArgumentException().isThrownBy(() -> Shape.box(1, 1, bad));
        assertThatIllegalArgumentException().isThrownBy(() -> Shape.plane(bad, 1));
    }

    @Test
    void normalisesOrientationsOfAnyMagnitude() {
        for (double scale : new double[] {1e-300, 1, 1e300}) {
            double[] unit =
                    ItemDefinition.named("ball")
                            .orientation(scale, -scale, scale, scale)
                            .build()
                            .orientation();
            assertThat(unit).containsExactly(new double[] {0.5, -0.5, 0.5, 0.5}, within(1e-15));
        }
    }

    @Test
    void refusesTheZeroQuaternion() {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ItemDefinition.named("ball").orientation(0, 0, 0, 0))
                .withMessageContaining("item ball: orientation is the zero quaternion");
    }

    @Test
    void refusesSymbolsThatTheWorldDerivesAndValuesOfOtherTypes() {
        var ball = ItemDefinition.named("ball");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.symbol("name", "other"))
                .withMessageContaining("derives");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.symbol("dimensions", 3))
                .withMessageContaining("derives");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.symbol("tags", List.of(List.of("a"))))
                .withMessageContaining("tags")
                .withMessageContaining("expected text");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.symbol("tags", Collections.nCopies(65, "a")))
                .withMessageContaining("65");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.symbol("story", "x".repeat(4097)))
                .withMessageContaining("4097");
    }

    @Test
    void readsColoursIntoBytesRedFirst() {
        Colour colour = Colour.parse("#0a1b2c3d");
        assertThat(colour.rgba() & 0xff).isEqualTo(0x0a);
        assertThat(colour.rgba() >> 8 & 0xff).isEqualTo(0x1b);
        assertThat(colour.rgba() >> 16 & 0xff).isEqualTo(0x2c);
        assertThat(colour.rgba() >>> 24).isEqualTo(0x3d);
        assertThat(colour).hasToString("#0a1b2c3d");
        assertThat(Colour.parse("#C0392B")).hasToString("#c0392bff");
    }

    @ParameterizedTest
    @ValueSource(strings = {"", "red", "#12345", "#1234567", "#123456789", "123456", "#12345g"})
    void refusesOtherColours(String text) {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> Colour.parse(text))
                .withMessageContaining("#rrggbb");
    }

    @Test
    void refusesMeshesWithBrokenNumbers() {
        float[] corners = {0, 0, 0, 1, 0, 0, 0, 1, 0};
        int[] triangle = {0, 1, 2};
        assertThatIllegalArgumentException()
                .isThrownBy(() -> Shape.mesh(corners, new int[] {0, 1, 3}))
                .withMessageContaining("triangle 0 refers to vertex 3, expected 0 to 2");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> Shape.mesh(corners, new int[] {0, -1, 2}));
        assertThatIllegalArgumentException().isThrownBy(() -> Shape.mesh(corners, new int[] {}));
        assertThatIllegalArgumentException().isThrownBy(() -> Shape.mesh(new float[4], triangle));
        assertThatIllegalArgumentException()
                .isThrownBy(
                        () -> Shape.mesh(new float[] {0, 0, 0, Float.NaN, 0, 0, 0, 1, 0}, triangle))
                .withMessageContaining("vertex 1")
                .withMessageContaining("NaN");
    }

    @Test
    void meshesAreCopiedAndMeasured() {
        float[] corners = {0, 0, 0, 2, 0, 0, 0, 3, -1};
        Mesh mesh = (Mesh) Shape.mesh(corners, new int[] {0, 1, 2});
        corners[3] = 99;
        assertThat(mesh.vertices().get(3)).isEqualTo(2);
        assertThat(mesh.size(0)).isEqualTo(2);
        assertThat(mesh.size(1)).isEqualTo(3);
        assertThat(mesh.size(2)).isEqualTo(1);
        assertThat(mesh.min(2)).isEqualTo(-1);
    }

    @Test
    void renamedKeepsEverythingButTheName() {
        ItemDefinition template =
                ItemDefinition.named("guest")
                        .shape(Shape.box(1, 2, 3))
                        .colour("#010203")
                        .at(4, 5, 6)
                        .orientation(1, 0, 0, 0)
                        .symbol("class", "visitor")
                        .physics("mass", 7)
                        .reference("end1", "x")
                        .build();
        ItemDefinition copy = template.renamed("ada");
        assertThat(copy.name()).isEqualTo("ada");
        assertThat(copy).usingRecursiveComparison().ignoringFields("name").isEqualTo(template);
    }
}
