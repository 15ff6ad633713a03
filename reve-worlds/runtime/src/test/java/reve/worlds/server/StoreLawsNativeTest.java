// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.frame.TimeBudget;
import reve.core.image.CorruptException;
import reve.pe.PreparedLibrary;
import reve.pe.adapter.LawLibrary;
import reve.pe.adapter.Laws;
import reve.pe.adapter.Quarantined;
import reve.worlds.journal.Journal;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.JournalSink;
import reve.worlds.journal.SqliteStore;
import reve.worlds.journal.StoreAddress;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.sql.Connection;
import java.sql.DriverManager;
import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** The laws of a store, compared with those of the world that resumes from it. */
class StoreLawsNativeTest {
    private static final LawPath LAWS = LawPath.ofShipped();

    private static final String WORLD =
            """
            reve: 1
            name: lawful
            frame: {rate: 60, steps: 1}
            laws: [newton_motion]
            items:
            - name: stone
              physical: {shape: sphere, radius: 0.1, location: [0, 5, 0]}
              physics: {mass: 1, velocity: [3, 0, 0]}
            """;

    @TempDir private Path folder;
    private Path store;

    /** A sink that stores no image after the first one, like a server that is killed. */
    private record Killed(JournalSink store, long[] images) implements JournalSink {
        @Override
        public void write(JournalRecord record) throws IOException {
            store.write(record);
        }

        @Override
        public Place place() throws IOException {
            if (images[0]++ > 0) {
                throw new IOException("killed");
            }
            return store.place();
        }

        @Override
        public void sync() throws IOException {
            store.sync();
        }

        @Override
        public void close() throws IOException {
            store.close();
        }
    }

    private StoredWorld open() throws Exception {
        WorldDescription description =
                WorldFile.parse("lawful.yaml", WORLD.getBytes(StandardCharsets.UTF_8));
        return StoredWorld.open(
                new StoreAddress.InFile(store),
                SqliteStore.Durability.NORMAL,
                description,
                Path.of("."),
                Pacing.FAST,
                LAWS,
                p -> {});
    }

    private static PreparedLibrary text(Simulation simulation, String name, String force) {
        String text =
                "law "
                        + name
                        + "\n  parameter f = 1 N, from -1000 N to 1000 N\n  each body:\n    force"
                        + " += "
                        + force
                        + "\n";
        return simulation
                .engine()
                .prepareText(name + ".law", text.getBytes(StandardCharsets.UTF_8));
    }

    private static int load(Simulation simulation, String name, String force) {
        try (PreparedLibrary prepared = text(simulation, name, force)) {
            return simulation.physics().laws().load(1, prepared, Map.of());
        }
    }

    /** Makes a store with each kind of change of laws in the frames after its only image. */
    private void makeStore() throws Exception {
        store = folder.resolve("my.db");
        StoredWorld world = open();
        try (Simulation simulation = world.simulation();
                Journal _ =
                        simulation.journal(
                                folder,
                                Map.of(),
                                new Journal.Plan(1000, true),
                                new Killed(world.store(), new long[1]),
                                problem -> {})) {
            Laws laws = simulation.physics().laws();
            simulation.loop().run(1);
            int push = load(simulation, "push", "f (1, 0, 0)");
            int gone = load(simulation, "gone", "f (0, 1, 0)");
            load(simulation, "pull", "-f (1, 0, 0)");
            simulation.loop().run(2);
            laws.unload(3, gone);
            laws.setParameters(3, "pull", Map.of("f", 0.5));
            try (PreparedLibrary again = text(simulation, "push", "2 f (1, 0, 0)")) {
                laws.replace(
                        3, push, again, Map.of("push.f", 4.0), Path.of("push.law"), made -> {});
            }
            laws.setBudget(
                    "pull", Optional.of(new TimeBudget(1000, 3, TimeBudget.Response.WARN, 2)));
            simulation.loop().run(2);
            load(simulation, "broken", "f * exp(1e5 * velocity.x / (1 m/s)) * (1, 0, 0)");
            simulation.loop().run(3);
            assertThat(laws.quarantined()).extracting(Quarantined::library).contains("broken");
        }
    }

    private static String text(LawLibrary library) {
        return library.name()
                + " "
                + library.sha256()
                + " "
                + library.parameters()
                + " "
                + library.budget();
    }

    @Test
    void theyAreThoseOfTheWorldThatResumes() throws Exception {
        makeStore();
        StoreLaws found = StoreLaws.of(new StoreAddress.InFile(store), LAWS);
        assertThat(found.problems()).isEmpty();
        assertThat(found.isWhole()).isTrue();
        assertThat(found.laws())
                .extracting(law -> law.library().name() + " " + law.kind())
                .containsExactly("newton_motion native", "push text", "pull text");
        StoredWorld world = open();
        try (Simulation resumed = world.simulation();
                JournalSink _ = world.store()) {
            assertThat(found.frame()).isEqualTo(resumed.loop().frame());
            Laws laws = resumed.physics().laws();
            assertThat(found.laws())
                    .extracting(law -> text(law.library()))
                    .isEqualTo(laws.libraries().stream().map(StoreLawsNativeTest::text).toList());
            assertThat(found.quarantined()).isEqualTo(laws.quarantined()).hasSize(1);
        }
        Map<String, Object> fields = found.fields();
        assertThat(fields).containsEntry("whole", true).containsKeys("frame", "problems");
        assertThat((List<?>) fields.get("laws")).hasSize(3);
        assertThat(((List<?>) fields.get("quarantined")).getFirst().toString())
                .contains("library=broken", "status=LAW_FAILED");
    }

    /** The laws are those of the last frame that is left. */
    @Test
    void aStoreThatLostFramesShowsTheLawsOfTheLastOneThatIsLeft() throws Exception {
        makeStore();
        Path frames = folder.resolve("my.db-frames-1");
        byte[] whole = Files.readAllBytes(frames);
        long last = StoreLaws.of(new StoreAddress.InFile(store), LAWS).frame();
        for (int length = whole.length - 1; length > whole.length / 2; length -= 97) {
            Files.write(frames, Arrays.copyOf(whole, length));
            StoreLaws found = StoreLaws.of(new StoreAddress.InFile(store), LAWS);
            StoreCheck checked = StoreCheck.of(new StoreAddress.InFile(store), LAWS);
            assertThat(found.isWhole()).isEqualTo(checked.isWhole());
            assertThat(found.problems()).isEqualTo(checked.problems());
            assertThat(found.frame()).isEqualTo(checked.frame()).isLessThan(last);
            List<String> names = found.laws().stream().map(law -> law.library().name()).toList();
            assertThat(names)
                    .as("at frame %d", found.frame())
                    .isEqualTo(
                            found.frame() < 2
                                    ? List.of("newton_motion")
                                    : found.frame() < 4
                                            ? List.of("newton_motion", "push", "gone", "pull")
                                            : List.of("newton_motion", "push", "pull"));
            assertThat(frames).hasBinaryContent(Arrays.copyOf(whole, length));
        }
    }

    @Test
    void aLawWhoseBytesAreLostIsNamedWithWhatToDo() throws Exception {
        makeStore();
        try (Connection connection = DriverManager.getConnection("jdbc:sqlite:" + store);
                var statement = connection.createStatement()) {
            statement.executeUpdate("UPDATE library SET bytes = zeroblob(length(bytes))");
        }
        StoreLaws found = StoreLaws.of(new StoreAddress.InFile(store), LAWS);
        assertThat(found.laws())
                .as("the shipped law is on the disk, and the texts are in the frames")
                .extracting(law -> law.library().name() + " " + law.kind())
                .startsWith("newton_motion native");
        LawPath nowhere =
                new LawPath(
                        Files.createDirectory(folder.resolve("none")),
                        Optional.empty(),
                        Optional.empty(),
                        false);
        StoreLaws lost = StoreLaws.of(new StoreAddress.InFile(store), nowhere);
        assertThat(lost.isWhole()).isFalse();
        assertThat(lost.laws())
                .extracting(law -> law.library().name() + " " + law.kind())
                .startsWith("newton_motion missing");
        assertThat(lost.problems())
                .anySatisfy(
                        problem ->
                                assertThat(problem)
                                        .contains(
                                                "the law library newton_motion (SHA-256 ",
                                                "is damaged or missing",
                                                "--laws"));
    }

    @Test
    void anEmptyStoreHasNoLaws() throws Exception {
        Path empty = Files.createFile(folder.resolve("empty.db"));
        assertThatExceptionOfType(CorruptException.class)
                .isThrownBy(() -> StoreLaws.of(new StoreAddress.InFile(empty), LAWS))
                .withMessageContaining("is an empty store");
    }
}
