// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.assertj.core.api.ThrowableAssert.ThrowingCallable;
import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.pe.Access;
import reve.pe.EngineFixture;
import reve.pe.NativeFiles;
import reve.pe.PhysicsException;
import reve.pe.PropertyDescriptor;
import reve.pe.Prototype;
import reve.pe.ScalarType;
import reve.pe.SiUnit;
import reve.pe.Status;

import java.nio.ByteBuffer;
import java.nio.channels.FileChannel;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.Set;

/** Every status that a client can cause arrives with its number, names and message. */
class VesperErrorsNativeTest {
    private final EngineFixture orbit =
            new EngineFixture(new EngineFixture.InProcess()).springOrbit();

    @AfterEach
    void close() {
        orbit.close();
    }

    @Test
    void invalidArgument() {
        PhysicsException e = refusal(() -> orbit.engine.advance(Double.NaN, 1));
        assertThat(e.status()).isEqualTo(Status.INVALID_ARGUMENT);
        assertThat(e).hasMessageContaining("dt is nan");
        assertThat(e.libraryId()).isZero();
        assertThat(e.row()).isEmpty();
    }

    @Test
    void notFound() {
        PhysicsException law = refusal(() -> orbit.load("no_such_law"));
        assertThat(law.status()).isEqualTo(Status.NOT_FOUND);
        assertThat(law)
                .hasMessageContaining("'no_such_law' was not found; looked for [")
                .hasMessageContaining("libvesper_law_no_such_law.so");
        PhysicsException property = refusal(() -> orbit.engine.propertyProvider().touch("weight"));
        assertThat(property.status()).isEqualTo(Status.NOT_FOUND);
        assertThat(property.property()).isEqualTo("weight");
        assertThat(refusal(() -> orbit.engine.unloadPhysicsLaw(77)).status())
                .isEqualTo(Status.NOT_FOUND);
        assertThat(refusal(() -> VesperEngine.standardPrototype("si-f16")).status())
                .isEqualTo(Status.NOT_FOUND);
    }

    @Test
    void alreadyExists() {
        orbit.load("wind");
        assertThat(refusal(() -> orbit.load("wind")).status()).isEqualTo(Status.ALREADY_EXISTS);
        assertThat(
                        refusal(
                                        () ->
                                                orbit.engine
                                                        .propertyProvider()
                                                        .addPhysicalProperty(
                                                                "mass",
                                                                orbit.arrays.get("mass"),
                                                                2))
                                .status())
                .isEqualTo(Status.ALREADY_EXISTS);
    }

    @Test
    void busy() {
        List<PhysicsException> refusals = new ArrayList<>();
        VesperEngine[] self = new VesperEngine[1];
        VesperConfig config =
                new VesperConfig(
                        1,
                        false,
                        NativeFiles.lawPath(),
                        (level, message) -> refusals.add(refusal(() -> self[0].clearFault())));
        self[0] = new VesperEngine(config, orbit.engine.prototype());
        try (VesperEngine engine = self[0]) {
            engine.propertyProvider().addPhysicalProperty("mass", orbit.arrays.get("mass"), 2);
            engine.loadPhysicsLaw("greets", Map.of());
            refusals.clear();
            engine.advance(1, 1);
            assertThat(refusals).extracting(PhysicsException::status).containsExactly(Status.BUSY);
        }
    }

    @Test
    void abiMismatch() {
        PhysicsException e = refusal(() -> orbit.load("other_abi"));
        assertThat(e.status()).isEqualTo(Status.ABI_MISMATCH);
        assertThat(e).hasMessageContaining("2.0").hasMessageContaining("1.");
    }

    @Test
    void typeMismatch() {
        List<PropertyDescriptor> flat = new ArrayList<>(orbit.engine.prototype().properties());
        flat.replaceAll(
                p ->
                        p.name().equals("velocity")
                                ? new PropertyDescriptor(
                                        "velocity",
                                        "body",
                                        ScalarType.F64,
                                        2,
                                        Set.of(Access.READ, Access.WRITE),
                                        p.unit(),
                                        null,
                                        null,
                                        p.doc())
                                : p);
        try (EngineFixture plane =
                new EngineFixture(
                                new EngineFixture.InProcess(),
                                new Prototype("plane", ScalarType.F64, SiUnit.SECOND, flat))
                        .lendAll()) {
            PhysicsException e = refusal(() -> plane.load("newton_motion"));
            assertThat(e.status()).isEqualTo(Status.TYPE_MISMATCH);
            assertThat(e.property()).isEqualTo("velocity");
        }
    }

    @Test
    void unitMismatch() {
        PhysicsException e = refusal(() -> orbit.load("other_units"));
        assertThat(e.status()).isEqualTo(Status.UNIT_MISMATCH);
        assertThat(e.property()).isEqualTo("mass");
    }

    @Test
    void countMismatch() {
        orbit.load("newton_motion")
                .engine
                .propertyProvider()
                .rebindPhysicalProperty("mass", orbit.arrays.get("mass"), 1);
        assertThat(refusal(() -> orbit.engine.advance(1, 1)).status())
                .isEqualTo(Status.COUNT_MISMATCH);
    }

    @Test
    void accessConflict() {
        PhysicsException e = refusal(() -> orbit.load("newton_motion", "rival_motion"));
        assertThat(e.status()).isEqualTo(Status.ACCESS_CONFLICT);
        assertThat(e).hasMessageContaining("rival_motion").hasMessageContaining("newton_motion");
    }

    /** A sparse file can have any size. Without the limit, it would be read completely. */
    @Test
    void aLibraryThatIsTooLargeIsNotRead(@TempDir Path folder) throws Exception {
        Path large = folder.resolve("large.so");
        try (var channel =
                FileChannel.open(large, StandardOpenOption.CREATE, StandardOpenOption.WRITE)) {
            channel.write(ByteBuffer.allocate(1), 40L << 30);
        }
        assertThat(refusal(() -> orbit.load(large.toString())))
                .returns(Status.LIBRARY_LOAD_FAILED, PhysicsException::status)
                .hasMessageContaining(
                        large
                                + " has 42949672961 bytes, expected a law library of at "
                                + "most 268435456");
    }

    @Test
    void libraryLoadFailed(@TempDir Path folder) throws Exception {
        Path garbage = Files.writeString(folder.resolve("garbage.so"), "I am no law library");
        assertThat(refusal(() -> orbit.load(garbage.toString())))
                .returns(Status.LIBRARY_LOAD_FAILED, PhysicsException::status)
                .hasMessageContaining(garbage.toString());
        byte[] whole = Files.readAllBytes(NativeFiles.testLaw("wind"));
        Path half = Files.write(folder.resolve("half.so"), Arrays.copyOf(whole, whole.length / 2));
        assertThat(refusal(() -> orbit.load(half.toString())))
                .returns(Status.LIBRARY_LOAD_FAILED, PhysicsException::status)
                .hasMessageContaining("truncated");
    }

    @Test
    void lawFailedNamesLibraryLawPropertyAndRow() {
        int id = orbit.engine.loadPhysicsLaw("returns_failure", Map.of());
        PhysicsException e = refusal(() -> orbit.engine.advance(1, 1));
        assertThat(e.status()).isEqualTo(Status.LAW_FAILED);
        assertThat(e.libraryId()).isEqualTo(id);
        assertThat(e.library()).isEqualTo("returns_failure");
        assertThat(e.law()).isEqualTo("returns_failure");
        assertThat(e.property()).isEqualTo("externalForce");
        assertThat(e.row()).hasValue(0);
        assertThat(e).hasMessageContaining("the bodies are too many for this law");
    }

    @Test
    void lawMisbehavedThenFaultedUntilCleared() {
        orbit.engine.loadPhysicsLaw("writes_nan", Map.of());
        PhysicsException e = refusal(() -> orbit.engine.advance(1, 1));
        assertThat(e.status()).isEqualTo(Status.LAW_MISBEHAVED);
        assertThat(e.law()).isEqualTo("writes_nan");
        assertThat(e.property()).isEqualTo("velocity");
        assertThat(e.row()).hasValue(1);
        assertThat(refusal(() -> orbit.engine.advance(1, 1)).status()).isEqualTo(Status.FAULTED);
        orbit.engine.clearFault();
        assertThat(refusal(() -> orbit.engine.advance(1, 1)).status())
                .isEqualTo(Status.LAW_MISBEHAVED);
    }

    private static PhysicsException refusal(ThrowingCallable call) {
        return catchThrowableOfType(PhysicsException.class, call);
    }
}
