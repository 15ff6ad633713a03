package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.stream.Stream;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;
import reve.core.file.WorldFile;
import reve.core.file.WorldWriter;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.world.Column;
import reve.core.world.Forces;
import reve.core.world.Item;
import reve.core.world.ScalarType;
import reve.core.world.Table;
import reve.core.world.World;
import reve.tests.Reve.Outcome;
import reve.worlds.server.Simulation;

/** A world that was saved to a world file goes on as if nothing had been. */
class SavedWorldIT {
    private static final int FRAMES = 30;

    @TempDir
    private Path folder = Path.of("");

    private static Simulation load(Path world) throws Exception {
        return new Simulation(WorldFile.load(world), Pacing.FAST);
    }

    private static Path sample(String name) {
        return Project.WORLDS.resolve(name).resolve("world.yaml");
    }

    @ParameterizedTest
    @ValueSource(strings = {"spring-orbit", "spiderweb"})
    void goesOnToTheBit(String sample) throws Exception {
        Path saved = folder.resolve("saved.yaml");
        try (Simulation first = load(sample(sample))) {
            first.loop().run(FRAMES);
            WorldFile.save(saved, first.descriptionNow());
            try (Simulation second = load(saved)) {
                for (int frame = 1; frame <= FRAMES; frame++) {
                    first.loop().step();
                    second.loop().step();
                    assertThat(state(second)).as("%d frames after saving", frame).isEqualTo(state(first));
                }
            }
        }
    }

    @ParameterizedTest
    @ValueSource(strings = {"spring-orbit", "spiderweb", "icosahedron"})
    void isTheSameWorldWhenItIsReadAgain(String sample) throws Exception {
        Path saved = folder.resolve("saved.yaml");
        try (Simulation first = load(sample(sample))) {
            first.loop().run(FRAMES);
            WorldFile.save(saved, first.descriptionNow());
            try (Simulation second = load(saved)) {
                second.loop().run(0); // derives what is not in the file
                assertThat(state(second)).isEqualTo(state(first));
                assertThat(WorldWriter.write(second.descriptionNow())).isEqualTo(Files.readString(saved));
            }
        }
    }

    /** The hash is over the steps done, too. */
    @Test
    void goesOnAtItsTime() throws Exception {
        Path saved = folder.resolve("saved.yaml");
        try (Simulation first = load(sample("spring-orbit"))) {
            first.loop().run(FRAMES);
            WorldFile.save(saved, first.descriptionNow());
            assertThat(Files.readString(saved)).contains("age: " + FRAMES);
            List<Double> times = new ArrayList<>();
            try (Simulation second = load(saved)) {
                second.onPublish("times", frame -> times.add(frame.timeSeconds()));
                second.loop().step();
                first.loop().step();
                Timing timing = second.description().timing();
                assertThat(times).containsExactly(timing.timeSeconds(FRAMES),
                        timing.timeSeconds(FRAMES + 1));
                assertThat(second.physics().stateHash()).isEqualTo(first.physics().stateHash());
            }
        }
    }

    @Test
    void whatItCannotHoldIsSaid() throws Exception {
        try (Simulation world = load(sample("spring-orbit"))) {
            assertThat(world.notDescribed()).isEmpty();
            world.world().forces().add(new Forces.Force(
                    world.world().find("red").orElseThrow().id(), List.of(1.0, 0.0, 0.0), 3));
            world.physics().laws().load(0, "surface_contact", Map.of());
            assertThat(world.notDescribed()).containsExactly("forces that still act: 1",
                    "what surface_contact remembers of earlier steps");
        }
    }

    /** Every number of every row that laws see, by bits, and what references refer to. */
    private static List<Object> state(Simulation simulation) {
        World world = simulation.world();
        List<Object> state = new ArrayList<>();
        for (Table table : world.tables()) {
            for (int row = 0; row < table.physicsRowCount(); row++) {
                Item item = world.item(table.idAt(row));
                state.add(item.name());
                for (Column column : table.columns()) {
                    for (int i = 0; i < column.components() && column.type() != ScalarType.REF; i++) {
                        state.add(Double.doubleToRawLongBits(column.getDouble(row, i)));
                    }
                }
                state.add(item.definition().references());
            }
        }
        return state;
    }

    @Test
    void runSavesWhatItEndsWith() throws Exception {
        Path saved = folder.resolve("orbit.yaml");
        String orbit = Project.WORLDS.resolve("spring-orbit").toString();

        Outcome run = Reve.run("run", orbit, "--seconds", "0.5", "--save", saved.toString());

        assertThat(run.code()).as(run.err()).isZero();
        assertThat(Reve.run("check", saved.toString()).out()).startsWith(saved + ": valid");
        assertThat(listing()).containsExactly("orbit.yaml");
        Outcome nowhere = Reve.run("run", orbit, "--seconds", "0", "--save",
                folder.resolve("none/x.yaml").toString());
        assertThat(nowhere.code()).isEqualTo(2);
        assertThat(nowhere.err()).contains("--save").contains("there is no folder");
    }

    private List<String> listing() throws IOException {
        try (Stream<Path> files = Files.list(folder)) {
            return files.map(file -> file.getFileName().toString()).toList();
        }
    }
}
