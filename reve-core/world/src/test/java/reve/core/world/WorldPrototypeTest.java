// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import org.junit.jupiter.api.Test;

import reve.core.unit.Unit;

import java.util.List;
import java.util.Optional;

class WorldPrototypeTest {

    private static PropertyDescriptor number(String name, String kind) {
        return new PropertyDescriptor(
                name, kind, ScalarType.F64, 1, Unit.parse("K"), Optional.empty(), "");
    }

    @Test
    void standardPrototypesDifferInTheirRealTypeOnly() {
        WorldPrototype f64 = WorldPrototype.standard("si-f64");
        WorldPrototype f32 = WorldPrototype.standard("si-f32");
        assertThat(f64.kinds()).containsExactly("body", "spring", "surface", "world");
        assertThat(f32.properties()).hasSameSizeAs(f64.properties());
        for (int i = 0; i < f64.properties().size(); i++) {
            PropertyDescriptor wide = f64.properties().get(i);
            PropertyDescriptor narrow = f32.properties().get(i);
            assertThat(narrow.name()).isEqualTo(wide.name());
            assertThat(narrow.unit().symbol()).isEqualTo(wide.unit().symbol());
            assertThat(narrow.type())
                    .isEqualTo(wide.type() == ScalarType.F64 ? ScalarType.F32 : wide.type());
        }
    }

    @Test
    void refusesUnknownPrototypes() {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> WorldPrototype.standard("si-f16"))
                .withMessageContaining("si-f16")
                .withMessageContaining("si-f64 or si-f32");
    }

    @Test
    void designersAddPropertiesAndKinds() {
        WorldPrototype extended =
                WorldPrototype.standard("si-f64")
                        .extendedBy(List.of(number("temperature", "body"), number("heat", "sun")));
        assertThat(extended.find("body", "temperature")).isPresent();
        assertThat(extended.find("spring", "temperature")).isEmpty();
        assertThat(extended.kinds()).endsWith("world", "sun");
        World world = new World("w", extended, new OffHeapArena());
        Item sun = world.add(ItemDefinition.named("sol").kind("sun").physics("heat", 5800).build());
        assertThat(sun.physics().scalar("heat")).isEqualTo(5800);
        assertThat(sun.physical().isEmpty()).isTrue();
    }

    @Test
    void aNameIsTakenOnceAcrossAllKindsAndAspects() {
        WorldPrototype standard = WorldPrototype.standard("si-f64");
        for (String taken : List.of("mass", "length", "position", "colour")) {
            assertThatIllegalArgumentException()
                    .isThrownBy(() -> standard.extendedBy(List.of(number(taken, "surface"))))
                    .withMessageContaining(taken)
                    .withMessageContaining("already taken");
        }
    }

    @Test
    void positionIsNoPhysicsProperty() {
        assertThat(WorldPrototype.standard("si-f64").find("body", "position")).isEmpty();
    }

    @Test
    void refusesReferencesToKindsThatDoNotExist() {
        var wrong =
                new PropertyDescriptor(
                        "owner",
                        "body",
                        ScalarType.REF,
                        1,
                        Unit.parse("1"),
                        Optional.of("ghost"),
                        "");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> WorldPrototype.standard("si-f64").extendedBy(List.of(wrong)))
                .withMessageContaining("owner")
                .withMessageContaining("ghost");
    }

    @Test
    void refusesDescriptorsThatContradictThemselves() {
        Unit one = Unit.parse("1");
        assertThatIllegalArgumentException()
                .isThrownBy(
                        () ->
                                new PropertyDescriptor(
                                        "a",
                                        "body",
                                        ScalarType.F64,
                                        1,
                                        one,
                                        Optional.of("body"),
                                        ""));
        assertThatIllegalArgumentException()
                .isThrownBy(
                        () ->
                                new PropertyDescriptor(
                                        "a", "body", ScalarType.REF, 1, one, Optional.empty(), ""));
        assertThatIllegalArgumentException()
                .isThrownBy(
                        () ->
                                new PropertyDescriptor(
                                        "a",
                                        "body",
                                        ScalarType.F64,
                                        17,
                                        one,
                                        Optional.empty(),
                                        ""));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> number("a-b", "body"))
                .withMessageContaining("a-b");
        assertThatIllegalArgumentException().isThrownBy(() -> number("x".repeat(48), "body"));
    }
}
