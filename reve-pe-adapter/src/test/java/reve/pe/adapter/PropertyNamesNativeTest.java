// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.unit.Unit;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.WorldPrototype;
import reve.pe.Access;
import reve.pe.Prototype;
import reve.pe.vesper.VesperEngine;

import java.util.List;
import java.util.Optional;
import java.util.Set;

class PropertyNamesNativeTest {
    @ParameterizedTest
    @ValueSource(strings = {"si-f64", "si-f32"})
    void everyStandardPropertyOfTheEngineIsOneOfReveInTypeAndUnit(String name) {
        Prototype engine = VesperEngine.standardPrototype(name);
        WorldPrototype world = WorldPrototype.standard(name).withJoints().withGears();
        Prototype reve =
                PropertyNames.prototype(world.extendedBy(world.propertiesOnDemand()), engine);
        assertThat(reve)
                .usingRecursiveComparison()
                .ignoringFieldsMatchingRegexes(".*doc", ".*symbol")
                .isEqualTo(engine);
    }

    @Test
    void springConstantAndEndsAreTranslated() {
        assertThat(PropertyNames.columns("spring", "hookeConstant"))
                .containsExactly("springConstant");
        assertThat(PropertyNames.columns("spring", "endpoints")).containsExactly("end1", "end2");
        assertThat(PropertyNames.columns("body", "mass")).containsExactly("mass");
    }

    @Test
    void whatADesignerAddsIsAppended() {
        WorldPrototype world =
                WorldPrototype.standard("si-f64")
                        .extendedBy(
                                List.of(
                                        new PropertyDescriptor(
                                                "temperature",
                                                "body",
                                                ScalarType.F32,
                                                1,
                                                Unit.parse("K"),
                                                Optional.empty(),
                                                0,
                                                "Of the surface."),
                                        new PropertyDescriptor(
                                                "axle",
                                                "wheel",
                                                ScalarType.REF,
                                                2,
                                                Unit.parse("1"),
                                                Optional.of("body"),
                                                "Both ends.")));
        Prototype prototype =
                PropertyNames.prototype(world, VesperEngine.standardPrototype("si-f64"));
        var temperature = prototype.find("temperature").orElseThrow();
        assertThat(temperature.type()).isEqualTo(reve.pe.ScalarType.F32);
        assertThat(temperature.lawAccess()).isEqualTo(Set.of(Access.READ, Access.WRITE));
        assertThat(temperature.unit().kelvin()).isEqualTo((byte) 1);
        assertThat(temperature.minimum()).isZero();
        var axle = prototype.find("axle").orElseThrow();
        assertThat(axle.kind()).isEqualTo("wheel");
        assertThat(axle.type()).isEqualTo(reve.pe.ScalarType.U32);
        assertThat(axle.components()).isEqualTo(2);
        assertThat(axle.refersTo()).isEqualTo("body");
        assertThat(axle.lawAccess()).isEqualTo(Set.of(Access.READ));
        assertThat(prototype.properties()).last().isEqualTo(axle);
    }
}
