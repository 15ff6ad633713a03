// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.Join;
import reve.core.frame.Pacing;
import reve.core.world.Column;
import reve.core.world.ScalarType;
import reve.core.world.Table;
import reve.tests.Reve.Outcome;
import reve.worlds.journal.RunLog;
import reve.worlds.server.Replay;
import reve.worlds.server.Simulation;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** The files of {@code export} hold the states that a replay of the recording makes. */
@Tag("slow")
class ExportIT {
    private static final String WORLD = Project.WORLDS.resolve("icosahedron").toString();

    @TempDir private Path folder;

    private Path recorded(String world, String seconds) throws Exception {
        Path log = folder.resolve("run.log");
        Outcome run = Reve.run("run", world, "--seconds", seconds, "--record", log.toString());
        assertThat(run.code()).as(run.err()).isZero();
        return log;
    }

    private static Outcome export(Path file, String... options) throws Exception {
        List<String> command = new ArrayList<>(List.of("export", file.toString()));
        command.addAll(List.of(options));
        return Reve.run(command.toArray(String[]::new));
    }

    /** Returns the rows of a table by frame and item: each a map from column to text. */
    private static Map<String, Map<String, String>> rows(Path table) throws IOException {
        List<String> lines = Files.readAllLines(table);
        String[] header = lines.getFirst().split(",");
        Map<String, Map<String, String>> rows = new LinkedHashMap<>();
        for (String line : lines.subList(1, lines.size())) {
            String[] cells = line.split(",", -1);
            Map<String, String> row = new LinkedHashMap<>();
            for (int i = 0; i < header.length; i++) {
                row.put(header[i], cells[i]);
            }
            rows.put(row.get("frame") + " " + row.get("id"), row);
        }
        return rows;
    }

    private static Simulation replayed(Path log, long frame) throws IOException {
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST);
                RunLog.Reader records = RunLog.open(log)) {
            while (records.hasNext() && replay.take(records.next(), frame)) {
                // reading a record runs its frame
            }
            return replay.release();
        }
    }

    private static List<String> names(Column column) {
        List<String> axes =
                switch (column.components()) {
                    case 1 -> List.of("");
                    case 3 -> List.of(".x", ".y", ".z");
                    case 4 -> List.of(".x", ".y", ".z", ".w");
                    default -> throw new AssertionError(column + " is new in this world");
                };
        return axes.stream()
                .map(axis -> column.name() + axis + " [" + column.unit().symbol() + "]")
                .toList();
    }

    @Test
    void theTablesHoldTheBitsOfTheReplay() throws Exception {
        Path log = recorded(WORLD, "1");
        Outcome outcome = export(log, "--csv", folder.resolve("csv").toString());
        assertThat(outcome.code()).as(outcome.err()).isZero();
        assertThat(outcome.out()).startsWith("61 frames, up to frame 60");
        int compared = 0;
        for (long frame : new long[] {1, 30, 60}) {
            try (Simulation simulation = replayed(log, frame)) {
                for (Table table : simulation.world().tables()) {
                    var rows = rows(folder.resolve("csv/" + table.kind() + ".csv"));
                    assertThat(rows).hasSize(61 * table.rowCount());
                    for (int row = 0; row < table.rowCount(); row++) {
                        Map<String, String> found = rows.get(frame + " " + table.idAt(row).value());
                        compared += compare(table, row, found);
                        assertThat(Double.parseDouble(found.get("time [s]")))
                                .isEqualTo(frame / 60.0);
                    }
                }
            }
        }
        assertThat(compared).isGreaterThan(2000);
    }

    /** Compares all numbers of a row, and returns their number. */
    private static int compare(Table table, int row, Map<String, String> found) {
        int compared = 0;
        for (Column column : table.columns()) {
            if (column.type() == ScalarType.REF
                    || column.name().equals("shape")
                    || column.name().equals("colour")) {
                continue;
            }
            for (int i = 0; i < column.components(); i++) {
                double expected = column.getDouble(row, i);
                assertThat(
                                Double.doubleToRawLongBits(
                                        Double.parseDouble(found.get(names(column).get(i)))))
                        .as("%s of %s", names(column).get(i), found)
                        .isEqualTo(Double.doubleToRawLongBits(expected));
                compared++;
            }
        }
        return compared;
    }

    @Test
    void equalRecordingsGiveEqualFiles() throws Exception {
        Path log = recorded(WORLD, "0.5");
        for (String name : List.of("a.mcap", "b.mcap")) {
            Outcome outcome =
                    export(log, "--mcap", folder.resolve(name).toString(), "--every", "10");
            assertThat(outcome.out()).startsWith("4 frames, up to frame 30");
        }
        assertThat(Files.mismatch(folder.resolve("a.mcap"), folder.resolve("b.mcap")))
                .isEqualTo(-1);
    }

    @Test
    void aStoreAndARecordingOfTheSameRunGiveTheSameTablesAndEvents() throws Exception {
        Path log = folder.resolve("run.log");
        Path store = folder.resolve("kept.db");
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        Project.WORLDS.resolve("spring-orbit").toString(),
                        "--port",
                        "0",
                        "--json",
                        "--record",
                        log.toString(),
                        "--store",
                        store.toString(),
                        "--store-every",
                        "1000")) {
            try (AgentClient ada = Agents.join(Integer.parseInt(server.port()), Join.as("ada"))) {
                ada.perceive();
            }
            server.events().await("left", any -> true);
            server.process().toHandle().destroy();
            server.events().untilEnd();
            assertThat(server.exitCode()).isZero();
        }
        Path ofLog = folder.resolve("log");
        Path ofStore = folder.resolve("store");
        assertThat(export(log, "--csv", ofLog.toString()).code()).isZero();
        Outcome outcome = export(store, "--csv", ofStore.toString());
        assertThat(outcome.code()).as(outcome.err()).isZero();
        assertThat(Files.readString(ofLog.resolve("frame-events.csv")))
                .contains(",joined,\"{\"\"agent\"\":\"\"ada\"\"")
                .contains(",left,\"{\"\"agent\"\":\"\"ada\"\"");
        List<String> all = Files.readAllLines(ofLog.resolve("body.csv"));
        List<String> kept = Files.readAllLines(ofStore.resolve("body.csv"));
        // a server that ends in order leaves an image of its last frame, and a store begins there
        assertThat(kept).hasSizeGreaterThan(1);
        assertThat(all).endsWith(kept.subList(1, kept.size()).toArray(String[]::new));
        Outcome ofTheLog = Reve.run("replay", log.toString());
        Outcome ofTheStore = Reve.run("replay", store.toString());
        assertThat(ofTheStore.code()).as(ofTheStore.err()).isZero();
        assertThat(ofTheStore.out().lines().toList().getLast())
                .startsWith("state hash: ")
                .isEqualTo(ofTheLog.out().lines().toList().getLast());
    }

    @Test
    void whatCannotBeExportedIsRefusedAndLeavesNoFile() throws Exception {
        Path log = recorded(WORLD, "0.2");
        Path out = folder.resolve("out.mcap");
        assertThat(export(log).err()).contains("expected --csv DIR, --mcap FILE or --json-ld FILE");
        Outcome kinds = export(log, "--mcap", out.toString(), "--kinds", "body,planet");
        assertThat(kinds.code()).isEqualTo(2);
        assertThat(kinds.err())
                .contains("the world has no kind \"planet\"; its kinds are body, spring, surface");
        Outcome world = export(Path.of(WORLD, "world.yaml"), "--mcap", out.toString());
        assertThat(world.code()).isEqualTo(1);
        assertThat(world.err()).contains("world.yaml is no recording");
        assertThat(export(log, "--csv", folder + "/c", "--pictures", "1").err())
                .contains("expected a time above 0, beside --mcap FILE");
        assertThat(export(log, "--mcap", out.toString(), "--camera", "side").err())
                .contains("are for pictures; expected --pictures S");
        Path letter = Files.writeString(folder.resolve("letter"), "to a friend");
        assertThat(export(log, "--mcap", letter.toString()).err())
                .contains("exists and is not an MCAP file");
        Path tables = Files.createDirectory(folder.resolve("tables"));
        Files.writeString(tables.resolve("body.csv"), "name,age\n");
        assertThat(export(log, "--csv", tables.toString()).err())
                .contains("exists and is not a table of export");

        byte[] damaged = Files.readAllBytes(log);
        damaged[damaged.length - 40] ^= 1;
        Files.write(log, damaged);
        Outcome broken = export(log, "--mcap", out.toString(), "--csv", tables + "2");
        assertThat(broken.code()).isEqualTo(1);
        assertThat(broken.err()).contains("run.log");
        assertThat(out).doesNotExist();
        assertThat(Path.of(tables + "2")).isEmptyDirectory();
        assertThat(folder.resolve("out.mcap.part")).doesNotExist();
    }
}
