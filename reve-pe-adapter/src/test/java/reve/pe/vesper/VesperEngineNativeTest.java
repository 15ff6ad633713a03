// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.pe.Access;
import reve.pe.EngineContract;
import reve.pe.EngineFixture;
import reve.pe.Prototype;
import reve.pe.ScalarType;
import reve.pe.SiUnit;

import java.lang.foreign.Arena;
import java.util.Set;

class VesperEngineNativeTest extends EngineContract {
    @Override
    protected EngineFixture.Home home() {
        return new EngineFixture.InProcess();
    }

    @Test
    void theStandardPrototypeComesFromTheLibrary() {
        Prototype prototype = VesperEngine.standardPrototype("si-f64");
        assertThat(prototype.realType()).isEqualTo(ScalarType.F64);
        assertThat(prototype.timeUnit()).isEqualTo(SiUnit.SECOND);
        assertThat(prototype.find("externalForce"))
                .hasValueSatisfying(
                        force -> {
                            assertThat(force.kind()).isEqualTo("body");
                            assertThat(force.components()).isEqualTo(3);
                            assertThat(force.lawAccess())
                                    .isEqualTo(Set.of(Access.READ, Access.ACCUMULATE));
                            assertThat(force.unit())
                                    .isEqualTo(
                                            SiUnit.of(
                                                    new byte[] {1, 1, -2, 0, 0, 0, 0},
                                                    1,
                                                    "newton"));
                            assertThat(force.initialFrom()).isEqualTo("appliedForce");
                        });
        assertThat(prototype.find("endpoints"))
                .hasValueSatisfying(
                        endpoints -> {
                            assertThat(endpoints.type()).isEqualTo(ScalarType.U32);
                            assertThat(endpoints.refersTo()).isEqualTo("body");
                        });
        assertThat(VesperEngine.standardPrototype("si-f32").realType()).isEqualTo(ScalarType.F32);
    }

    @Test
    void theBuildIsNamed() {
        assertThat(VesperEngine.buildInfo()).contains("contract 1.2");
    }

    @Test
    void aPrototypeSurvivesTheWayToTheEngineAndBack() {
        try (Arena arena = Arena.ofConfined()) {
            Prototype prototype = VesperEngine.standardPrototype("si-f64");
            assertThat(VesperPrototypes.read(VesperPrototypes.write(arena, prototype)))
                    .isEqualTo(prototype);
        }
    }
}
