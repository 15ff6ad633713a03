// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.offset;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.world.OffHeapArena;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;
import reve.pe.NativeFiles;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.Status;

import java.io.IOException;
import java.io.UncheckedIOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.nio.file.StandardOpenOption;
import java.nio.file.attribute.FileTime;
import java.nio.file.attribute.PosixFilePermissions;
import java.time.Duration;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Set;

class LawFolderNativeTest {
    /** Gain of speed per frame under a force of 1 N on 1 kg [m/s]. */
    private static final double GAIN = 1.0 / 60;

    @TempDir private Path folder;
    private final AdapterFixture world =
            new AdapterFixture(
                    WorldPrototype.standard("si-f64"),
                    List.of(),
                    new OffHeapArena(),
                    true,
                    real -> engine = new FailingEngine(real));
    private FailingEngine engine;
    private LawFolder laws;

    @BeforeEach
    void follow() {
        world.world.add(AdapterFixture.body("stone", 1, 0, 0, 0, 0, 0, 0));
        world.load("newton_motion");
        laws =
                new LawFolder(
                        LawFolder.ORIGIN,
                        folder,
                        world.engine,
                        world.adapter.laws(),
                        world.commands,
                        this::parameters);
    }

    @AfterEach
    void close() {
        laws.close();
        world.close();
    }

    /**
     * Replaces the reader of YAML, which this project does not have. The file has one line {@code
     * name value}.
     */
    private FolderParameters parameters(String library, Path file) {
        try {
            String[] words = Files.readString(file).strip().split(" ");
            Map<String, Double> values =
                    words.length < 2 ? Map.of() : Map.of(words[0], Double.valueOf(words[1]));
            return new FolderParameters(
                    values,
                    laws -> {
                        assertThat(laws).extracting(PhysicsLaw::library).containsOnly(library);
                        if (words.length > 2) {
                            throw new PhysicsException(
                                    Status.INVALID_ARGUMENT, file + ": unit " + words[2]);
                        }
                    });
        } catch (IOException e) {
            throw new UncheckedIOException(e);
        }
    }

    @Test
    void theFileBesideALawSetsItsParametersWhileItRuns() throws IOException {
        Path beside = folder.resolve("wind.yaml");
        Files.writeString(beside, "force 3");
        drop("wind", "libvesper_law_wind.so");
        lookAndRun(2);
        assertThat(speed()).isCloseTo(3 * GAIN, offset(1e-14));
        Files.writeString(beside, "force 10");
        lookAndRun(2);
        assertThat(speed()).isCloseTo(3 * GAIN + 3 * GAIN + 10 * GAIN, offset(1e-13));
        Files.writeString(beside, "force 2 kg");
        lookAndRun(2);
        assertThat(world.events("fault"))
                .last()
                .satisfies(
                        event ->
                                assertThat(String.valueOf(event.fields().get("message")))
                                        .contains("wind.yaml: unit kg"));
        assertThat(speed()).as("as before").isCloseTo(36 * GAIN, offset(1e-13));
        Files.delete(beside);
        lookAndRun(2);
        assertThat(speed()).as("the default").isCloseTo(47 * GAIN, offset(1e-13));
        assertThat(loaded()).containsExactly("newton_motion", "wind");
        Files.delete(folder.resolve("libvesper_law_wind.so"));
        lookAndRun(1);
        assertThat(loaded()).containsExactly("newton_motion");
    }

    @Test
    void aLawWhoseParametersHaveWrongUnitsIsNotLoaded() throws IOException {
        Files.writeString(folder.resolve("wind.yaml"), "force 3 kg");
        drop("wind", "wind.so");
        lookAndRun(3);
        assertThat(loaded()).containsExactly("newton_motion");
        assertThat(speed()).isZero();
        assertThat(world.events("fault")).hasSize(1);
        Files.writeString(folder.resolve("wind.yaml"), "force 3");
        lookAndRun(2);
        assertThat(loaded()).containsExactly("newton_motion", "wind");
    }

    @Test
    void aDroppedLawActsOnceItLookedTheSameTwice() throws IOException {
        drop("wind", "wind.so");
        lookAndRun(1);
        assertThat(loaded()).containsExactly("newton_motion");
        lookAndRun(1);
        assertThat(loaded()).containsExactly("newton_motion", "wind");
        assertThat(speed()).isCloseTo(GAIN, offset(1e-15));
        assertThat(world.events("law-loaded"))
                .last()
                .satisfies(
                        event -> {
                            assertThat(event.frame()).isEqualTo(2);
                            assertThat(event.fields()).containsEntry("library", "wind");
                        });
    }

    @Test
    void aLawAsTextActsIsReplacedAndRefusedWithItsPlace() throws IOException {
        Path file = folder.resolve("push.law");
        Files.writeString(file, "law push\n  each body:\n    force += (1, 0, 0) N\n");
        lookAndRun(3);
        assertThat(loaded()).containsExactly("newton_motion", "push");
        double before = speed();
        Files.writeString(file, "law push\n  each body:\n    force += velocity * mass\n");
        lookAndRun(3);
        assertThat(loaded()).containsExactly("newton_motion", "push");
        assertThat(world.events("fault"))
                .last()
                .satisfies(
                        event ->
                                assertThat(String.valueOf(event.fields().get("message")))
                                        .contains("push.law:3:14: 'velocity * mass' is a vector in")
                                        .contains("divide it by dt"));
        assertThat(speed()).isGreaterThan(before);
        Files.writeString(file, "law push\n  each body:\n    force += (0, 0, 0) N\n");
        lookAndRun(3);
        double coasting = speed();
        lookAndRun(2);
        assertThat(speed()).isEqualTo(coasting);
        Files.delete(file);
        lookAndRun(2);
        assertThat(loaded()).containsExactly("newton_motion");
    }

    @Test
    void aFileThatKeepsGrowingWaitsUntilItIsWhole() throws IOException {
        byte[] whole = Files.readAllBytes(NativeFiles.testLaw("wind"));
        Path file = folder.resolve("wind.so");
        Files.createFile(file);
        for (int i = 0; i < 8; i++) {
            Files.write(
                    file,
                    Arrays.copyOfRange(whole, whole.length * i / 8, whole.length * (i + 1) / 8),
                    StandardOpenOption.APPEND);
            lookAndRun(1 + i % 4);
        }
        lookAndRun(2);
        assertThat(loaded()).contains("wind");
        assertThat(world.events("fault")).isEmpty();
    }

    @Test
    void aRemovedLawStops() throws IOException {
        Path file = drop("wind", "wind.so");
        lookAndRun(3);
        double speed = speed();
        Files.delete(file);
        lookAndRun(2);
        assertThat(speed()).isEqualTo(speed);
        assertThat(loaded()).containsExactly("newton_motion");
        assertThat(world.events("law-unloaded")).hasSize(1);
        assertThat(Files.readString(Path.of("/proc/self/maps"))).doesNotContain("wind.so");
        drop("wind", "wind.so");
        lookAndRun(2);
        assertThat(loaded()).contains("wind");
    }

    @Test
    void aLawThatTheWorldLoadedFromTheFolderBelongsToItsFile() throws IOException {
        Path file = drop("wind", "wind.so");
        try (PreparedLibrary wind = engine.prepare(file)) {
            world.adapter
                    .laws()
                    .leaveToFolder(world.adapter.laws().load(0, wind, Map.of("force", 2.0)));
        }
        lookAndRun(2);
        assertThat(loaded()).containsExactly("newton_motion", "wind");
        assertThat(world.events("fault")).isEmpty();
        Files.delete(file);
        lookAndRun(2);
        assertThat(loaded()).containsExactly("newton_motion");
    }

    @Test
    void aLawThatARestoredWorldBroughtAlongBelongsToItsFileAgain() throws IOException {
        byte[] bytes = Files.readAllBytes(NativeFiles.testLaw("wind"));
        try (PreparedLibrary wind = engine.prepare(bytes)) {
            world.adapter
                    .laws()
                    .apply(0, new LawChange.Loaded(LawLibrary.of(wind, Map.of("force", 2.0))));
        }
        Path file = drop("wind", "wind.so");
        lookAndRun(2);
        assertThat(loaded()).containsExactly("newton_motion", "wind");
        assertThat(speed()).isCloseTo(2 * 2 * GAIN, offset(1e-15));
        assertThat(world.events("fault")).isEmpty();
        Files.delete(file);
        lookAndRun(2);
        assertThat(loaded()).containsExactly("newton_motion");
    }

    /** In this test, the file changed while no server ran. */
    @Test
    void aFileTakesThePlaceOfTheLawOfItsNameInARestoredWorld() throws IOException {
        byte[] bytes = Files.readAllBytes(NativeFiles.testLaw("wind"));
        try (PreparedLibrary wind = engine.prepare(bytes)) {
            world.adapter
                    .laws()
                    .apply(0, new LawChange.Loaded(LawLibrary.of(wind, Map.of("force", 3.0))));
        }
        Path file = drop("strong_wind", "wind.so");
        lookAndRun(3);
        assertThat(world.events("fault")).isEmpty();
        assertThat(loaded()).containsExactly("newton_motion", "wind");
        double speed = speed();
        lookAndRun(2);
        assertThat(speed() - speed).as("its own force of 2 N").isCloseTo(4 * GAIN, offset(1e-15));
        Files.delete(file);
        lookAndRun(2);
        assertThat(loaded()).containsExactly("newton_motion");
    }

    @Test
    void aReplacedLawIsExchangedBetweenTwoFrames() throws IOException {
        drop("wind", "wind.so");
        lookAndRun(2);
        drop("strong_wind", "wind.so");
        lookAndRun(2);
        // The weak wind acted in one more frame, until the new file no longer changed. Then the
        // strong wind acted.
        assertThat(speed()).isCloseTo(GAIN + GAIN + 2 * GAIN, offset(1e-15));
        assertThat(loaded()).containsExactly("newton_motion", "wind");
        assertThat(world.events)
                .filteredOn(event -> event.frame() == 4)
                .extracting(WorldEvent::type)
                .containsExactly("law-unloaded", "law-loaded");
    }

    @Test
    void aLawStaysWhenItsReplacementIsRefused() throws IOException {
        drop("wind", "wind.so");
        lookAndRun(2);
        drop("rival_motion", "wind.so");
        lookAndRun(3);
        assertThat(loaded()).containsExactly("newton_motion", "wind");
        assertThat(speed()).isCloseTo(4 * GAIN, offset(1e-15));
        assertThat(world.events("fault"))
                .singleElement()
                .satisfies(
                        fault ->
                                assertThat(fault.fields())
                                        .containsEntry("source", "laws folder")
                                        .containsEntry("file", "wind.so")
                                        .containsEntry("status", "ACCESS_CONFLICT"));
    }

    @Test
    void aLawStaysHoweverManyReplacementsAreRefusedAndGoesForAGoodOne() throws IOException {
        drop("wind", "wind.so");
        lookAndRun(2);
        for (int i = 0; i < 3; i++) {
            drop("rival_motion", "wind.so");
            Files.setLastModifiedTime(folder.resolve("wind.so"), FileTime.fromMillis(i));
            lookAndRun(3);
            assertThat(loaded()).containsExactly("newton_motion", "wind");
        }
        assertThat(world.events("fault"))
                .hasSize(3)
                .allSatisfy(
                        fault ->
                                assertThat(fault.fields())
                                        .containsEntry("status", "ACCESS_CONFLICT"));
        drop("strong_wind", "wind.so");
        lookAndRun(2);
        double before = speed();
        lookAndRun(1);
        assertThat(speed() - before).isCloseTo(2 * GAIN, offset(1e-15));
    }

    @Test
    void aLawStaysEvenIfNothingCouldBeLoadedAnyMore() throws IOException {
        drop("wind", "wind.so");
        lookAndRun(2);
        engine.refusals = Integer.MAX_VALUE;
        drop("strong_wind", "wind.so");
        lookAndRun(3);
        assertThat(world.events("fault")).hasSize(1);
        assertThat(loaded()).containsExactly("newton_motion", "wind");
        assertThat(speed()).isCloseTo(4 * GAIN, offset(1e-15));
        engine.refusals = 0;
        drop("strong_wind", "wind.so");
        Files.setLastModifiedTime(folder.resolve("wind.so"), FileTime.fromMillis(1));
        lookAndRun(2);
        double before = speed();
        lookAndRun(1);
        assertThat(speed() - before).isCloseTo(2 * GAIN, offset(1e-15));
    }

    /** Some replacements follow directly after a refused one, and some are two within one frame. */
    @Test
    void aLawIsReplacedManyTimesInItsPlace() throws IOException {
        drop("wind", "wind.so");
        lookAndRun(2);
        world.load("greets");
        int id = world.adapter.laws().byId().keySet().stream().skip(1).findFirst().orElseThrow();
        List<LawChange> told = new ArrayList<>();
        world.adapter.laws().addListener(told::add);
        double expected = speed();
        for (int i = 0; i < 40; i++) {
            int strength = i % 2 == 0 ? 2 : 1;
            if (i % 5 == 0) {
                drop("rival_motion", "wind.so");
                Files.setLastModifiedTime(folder.resolve("wind.so"), FileTime.fromMillis(-1 - i));
                laws.look();
                laws.look();
            }
            drop(strength == 2 ? "strong_wind" : "wind", "wind.so");
            Files.setLastModifiedTime(folder.resolve("wind.so"), FileTime.fromMillis(1 + i));
            laws.look();
            laws.look();
            world.run(1);
            expected += strength * GAIN;
            assertThat(speed()).as("replacement %d", i).isCloseTo(expected, offset(1e-12));
            assertThat(world.adapter.laws().byId().keySet()).element(1).isEqualTo(id);
            assertThat(loaded()).containsExactly("newton_motion", "wind", "greets");
        }
        assertThat(told)
                .hasSize(40)
                .allSatisfy(
                        change ->
                                assertThat(change)
                                        .isInstanceOfSatisfying(
                                                LawChange.Replaced.class,
                                                replaced -> assertThat(replaced.place()).isOne()));
        assertThat(world.events("fault")).hasSize(8);
        assertThat(Files.readAllLines(Path.of("/proc/self/maps")))
                .filteredOn(line -> line.contains("wind.so"))
                .extracting(line -> line.split("-")[0].length())
                .hasSizeLessThan(12); // the parts of one library
    }

    @Test
    void renamedFilesKeepTheirLaws() throws IOException {
        drop("wind", "wind.so");
        push("push.law", "push", 4);
        push("pull.law", "pull", -1);
        lookAndRun(2);
        List<Integer> ids = List.copyOf(world.adapter.laws().byId().keySet());
        double before = speed();
        Files.move(folder.resolve("wind.so"), folder.resolve("breeze.so"));
        Files.move(folder.resolve("push.law"), folder.resolve("third"));
        Files.move(folder.resolve("pull.law"), folder.resolve("push.law"));
        Files.move(folder.resolve("third"), folder.resolve("pull.law"));
        lookAndRun(3);
        assertThat(speed() - before).isCloseTo(3 * 4 * GAIN, offset(1e-13));
        assertThat(world.adapter.laws().byId().keySet()).containsExactlyElementsOf(ids);
        assertThat(world.events("law-unloaded")).isEmpty();
        assertThat(world.events("law-loaded")).hasSize(4);
        assertThat(world.events("fault")).isEmpty();
        Files.delete(folder.resolve("pull.law")); // which contains the law push now
        lookAndRun(1);
        assertThat(loaded()).containsExactlyInAnyOrder("newton_motion", "wind", "pull");
    }

    @Test
    void filesExchangeTheirContents() throws IOException {
        push("a.law", "push", 4);
        push("b.law", "pull", -1);
        lookAndRun(2);
        double before = speed();
        for (int i = 1; i <= 4; i++) {
            push(i % 2 == 0 ? "a.law" : "b.law", "push", 4 + i);
            push(i % 2 == 0 ? "b.law" : "a.law", "pull", -1 - i);
            laws.look();
            laws.look();
            world.run(1);
            assertThat(speed() - before)
                    .as("exchange %d", i)
                    .isCloseTo(3 * i * GAIN, offset(1e-13));
            assertThat(loaded()).containsExactly("newton_motion", "push", "pull");
        }
        assertThat(world.events("fault")).isEmpty();
        push("a.law", "pull", -5); // and back, with the same bytes as in b.law
        push("b.law", "push", 8);
        int events = world.events.size();
        lookAndRun(3);
        assertThat(world.events).hasSize(events);
        assertThat(loaded()).containsExactly("newton_motion", "push", "pull");
    }

    /** The names of the laws of a file are checked after the engine has taken the library. */
    @Test
    void aFileThatIsRefusedAfterItWasTakenIsReportedWithTheReason() throws IOException {
        Set<String> checked = new HashSet<>();
        world.adapter
                .laws()
                .guardNames(
                        (name, file, bytes) -> {
                            if (file.endsWith("b.law") && !checked.add(name)) {
                                throw new PhysicsException(
                                        Status.ALREADY_EXISTS, name + " is another law's name");
                            }
                        });
        push("a.law", "push", 4);
        push("b.law", "pull", -1);
        lookAndRun(3);
        assertThat(loaded()).containsExactly("newton_motion", "push");
        assertThat(world.events("fault"))
                .extracting(event -> event.fields().get("message"))
                .containsExactly("pull is another law's name");
    }

    /**
     * Two files change together. First, the engine refuses one of them. Then one law gets a new
     * name, and the other law gets the name that the first one had.
     */
    @Test
    void filesThatChangeTogetherActTogetherFromOneFrameOn() throws IOException {
        push("a.law", "push", 4);
        push("b.law", "pull", -1);
        lookAndRun(2);
        push("a.law", "push", 10);
        push("b.law", "broken velocity", 1);
        lookAndRun(2);
        double before = speed();
        lookAndRun(1);
        assertThat(speed() - before).as("old pull, new push").isCloseTo(9 * GAIN, offset(1e-13));
        push("a.law", "pull", -2);
        push("b.law", "pushes", 20);
        lookAndRun(2);
        assertThat(speed() - before).isCloseTo((9 + 9 + 18) * GAIN, offset(1e-13));
        assertThat(loaded()).containsExactly("newton_motion", "pushes", "pull");
    }

    private void push(String file, String law, int newtons) throws IOException {
        Files.writeString(
                folder.resolve(file),
                "law " + law + "\n  each body:\n    force += (" + newtons + ", 0, 0) N\n");
    }

    @Test
    void aFileThatTheEngineStumblesOverHarmsNoOther() throws IOException {
        drop("wind", "odd.so");
        drop("wind", "wind.so");
        lookAndRun(3);
        assertThat(loaded()).containsExactly("newton_motion", "wind");
        assertThat(world.events("fault"))
                .singleElement()
                .satisfies(
                        fault ->
                                assertThat(fault.fields())
                                        .containsEntry("file", "odd.so")
                                        .containsEntry("status", "LIBRARY_LOAD_FAILED"));
    }

    @Test
    void theFoldersCommandsHaveAnOriginThatNoAgentCanHave() {
        assertThat(LawFolder.ORIGIN).doesNotMatch("[A-Za-z0-9_.-]*");
    }

    @Test
    void aTouchedFileOfTheSameBytesChangesNothing() throws IOException {
        Path file = drop("wind", "wind.so");
        lookAndRun(2);
        Files.setLastModifiedTime(file, FileTime.fromMillis(1));
        lookAndRun(3);
        assertThat(world.events("law-loaded")).hasSize(2);
        assertThat(world.events("law-unloaded")).isEmpty();
    }

    @Test
    void whatIsNoLawIsToldOnceAndCostsNothingElse() throws IOException {
        Path file = Files.writeString(folder.resolve("garbage.so"), "I am no law");
        lookAndRun(11);
        assertThat(world.events("fault")).isEmpty();
        lookAndRun(20);
        Files.setLastModifiedTime(file, FileTime.fromMillis(1));
        lookAndRun(20);
        assertThat(world.events("fault"))
                .singleElement()
                .satisfies(
                        fault ->
                                assertThat(fault.fields())
                                        .containsEntry("source", "laws folder")
                                        .containsEntry("file", "garbage.so")
                                        .containsEntry("status", "LIBRARY_LOAD_FAILED"));
        assertThat(loaded()).containsExactly("newton_motion");
    }

    @Test
    void aLawForAnotherContractIsToldAtOnce() throws IOException {
        drop("other_abi", "other.so");
        lookAndRun(3);
        assertThat(world.events("fault"))
                .singleElement()
                .satisfies(
                        fault ->
                                assertThat(fault.fields()).containsEntry("status", "ABI_MISMATCH"));
    }

    @Test
    void linksPipesAndFoldersAreIgnoredWithTheReason() throws Exception {
        Files.createSymbolicLink(folder.resolve("a.so"), NativeFiles.testLaw("wind"));
        Files.createDirectory(folder.resolve("b.so"));
        assertThat(
                        new ProcessBuilder("mkfifo", folder.resolve("c.so").toString())
                                .start()
                                .waitFor())
                .isZero();
        Files.writeString(folder.resolve("README"), "not a law, and not meant to be one");
        lookAndRun(4);
        assertThat(world.events("fault"))
                .extracting(event -> String.valueOf(event.fields().get("message")))
                .satisfiesExactly(
                        link -> assertThat(link).contains("found a symbolic link"),
                        directory -> assertThat(directory).contains("found a folder"),
                        pipe -> assertThat(pipe).contains("found a special file"));
        assertThat(loaded()).containsExactly("newton_motion");
    }

    @Test
    void aLawThatFailsStaysOutUntilItsFileHoldsOtherBytes() throws IOException {
        drop("returns_failure", "mine.so");
        lookAndRun(3);
        assertThat(world.events("fault")).hasSize(1);
        assertThat(world.adapter.laws().quarantined())
                .extracting(Quarantined::library)
                .containsExactly("returns_failure");
        drop("returns_failure", "copy.so");
        lookAndRun(3);
        assertThat(world.events("fault"))
                .hasSize(2)
                .last()
                .satisfies(
                        fault ->
                                assertThat(fault.fields().get("message"))
                                        .asString()
                                        .contains("in quarantine"));
        drop("wind", "mine.so");
        lookAndRun(2);
        assertThat(loaded()).containsExactly("newton_motion", "wind");
    }

    @Test
    void aFullFolderIgnoresWhatComesLater() throws IOException {
        for (int i = 0; i <= LawFolder.MAX_LIBRARIES; i++) {
            drop("greets", "law-%03d.so".formatted(i));
        }
        lookAndRun(3);
        assertThat(world.events("fault"))
                .filteredOn(
                        fault ->
                                String.valueOf(fault.fields().get("message"))
                                        .contains("the folder has 64"))
                .singleElement()
                .satisfies(fault -> assertThat(fault.fields()).containsEntry("file", "law-064.so"));
    }

    @Test
    void lawsStayAsTheyAreWhenTheFolderCannotBeRead() throws IOException {
        drop("wind", "wind.so");
        lookAndRun(2);
        Path away = Files.move(folder, folder.resolveSibling(folder.getFileName() + "-away"));
        lookAndRun(3);
        assertThat(loaded()).containsExactly("newton_motion", "wind");
        Files.move(away, folder);
        lookAndRun(3);
        assertThat(world.events("law-loaded")).hasSize(2);
        assertThat(world.events("law-unloaded")).isEmpty();
    }

    @Test
    void aFolderThatIsNoneOrOpenToEverybodyIsRefused() throws IOException {
        Path file = Files.createFile(folder.resolve("file"));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> followAnother(file))
                .withMessage(
                        "laws folder " + file + " is not a folder; create it, or name another");
        Path open = Files.createDirectory(folder.resolve("open"));
        Files.setPosixFilePermissions(open, PosixFilePermissions.fromString("rwxrwxrwx"));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> followAnother(open))
                .withMessageContaining("can be written by every user");
    }

    /** While the world runs, the folder may be removed and created again. */
    @Test
    void aFolderThatEveryUserCanWriteToIsNotFollowed() throws IOException {
        Files.setPosixFilePermissions(folder, PosixFilePermissions.fromString("rwxrwxrwx"));
        drop("wind", "wind.so");
        lookAndRun(3);
        assertThat(loaded()).containsExactly("newton_motion");
        Files.setPosixFilePermissions(folder, PosixFilePermissions.fromString("rwxr-xr-x"));
        lookAndRun(3);
        assertThat(loaded()).containsExactly("newton_motion", "wind");
    }

    @Test
    void theFoldersOwnThreadFollowsByItself() throws IOException {
        drop("wind", "wind.so");
        laws.start();
        long deadline = System.nanoTime() + Duration.ofSeconds(300).toNanos();
        while (loaded().size() < 2 && System.nanoTime() < deadline) {
            world.run(1);
        }
        assertThat(loaded()).containsExactly("newton_motion", "wind");
    }

    @Test
    void closingDropsWhatNoFrameTook() throws IOException {
        drop("wind", "wind.so");
        laws.look();
        laws.look();
        assertThat(Files.readString(Path.of("/proc/self/maps"))).contains("wind.so");
        laws.close();
        assertThat(Files.readString(Path.of("/proc/self/maps"))).doesNotContain("wind.so");
    }

    private void followAnother(Path path) {
        new LawFolder(
                        LawFolder.ORIGIN,
                        path,
                        world.engine,
                        world.adapter.laws(),
                        world.commands,
                        this::parameters)
                .close();
    }

    private Path drop(String law, String name) throws IOException {
        return Files.copy(
                NativeFiles.testLaw(law),
                folder.resolve(name),
                StandardCopyOption.REPLACE_EXISTING);
    }

    private void lookAndRun(int times) {
        for (int i = 0; i < times; i++) {
            laws.look();
            world.run(1);
        }
    }

    private double speed() {
        return world.velocity("stone")[0];
    }

    private List<String> loaded() {
        return world.adapter.laws().loaded().stream().map(PhysicsLaw::name).toList();
    }
}
