// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.Experiment;
import reve.worlds.server.LawPath;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** The journal of the finished runs of an experiment. */
class RunJournalTest {
    @TempDir private Path folder;
    private Path out;
    private LawPath laws;

    @BeforeEach
    void writeTheExperiment() throws IOException {
        out = Files.createDirectory(folder.resolve("out"));
        Files.writeString(
                folder.resolve("world.yaml"),
                """
                reve: 1
                name: w
                laws: [wind]
                items: [{name: ball, physics: {mass: 1 kg}}]
                """);
        Files.writeString(
                folder.resolve("e.yaml"),
                """
                experiment: 1
                name: e
                world: world.yaml
                seconds: 1
                seeds: 4
                measures:
                  a: {of: ball, is: physics.mass}
                  b: {of: ball, is: physics.velocity}
                """);
        Path shipped = Files.createDirectory(folder.resolve("shipped"));
        Files.writeString(shipped.resolve("wind.law"), "law wind: one");
        laws = new LawPath(shipped, Optional.empty(), Optional.empty(), false);
    }

    private RunJournal open() throws Exception {
        return RunJournal.open(out, Experiment.load(folder.resolve("e.yaml")), laws);
    }

    private Path file() {
        return out.resolve(RunJournal.NAME);
    }

    /** Returns a result with every form of a value. */
    private static RunResult result(Experiment experiment, int index, RunResult.State state) {
        List<Optional<Object>> first =
                List.of(Optional.of(0.1 + index), Optional.of(List.of(-0.0, 1e-300, 3.0)));
        List<Optional<Object>> second = List.of(Optional.empty(), Optional.of("a \"b\"\nc"));
        List<Optional<Object>> third = List.of(Optional.of(true), Optional.of(Double.NaN));
        return new RunResult(
                experiment.point(index),
                state,
                "message " + index,
                60,
                "0123456789abcdef",
                List.of(
                        new Sample(0, 0, first),
                        new Sample(30, 0.5, second),
                        new Sample(60, 1 / 3.0, third)),
                List.of(Optional.of(Math.PI), Optional.of(Double.NEGATIVE_INFINITY)),
                List.of(Optional.of(-0.0), Optional.empty()),
                List.of("a note"),
                Map.of("wind", "00ff"));
    }

    private void write(RunResult.State... states) throws Exception {
        try (RunJournal journal = open()) {
            Experiment experiment = Experiment.load(folder.resolve("e.yaml"));
            for (int i = 0; i < states.length; i++) {
                journal.uses(experiment.plan(i));
                journal.add(result(experiment, i, states[i]));
            }
        }
    }

    @Test
    void aResultIsReadAgainToTheBit() throws Exception {
        write(RunResult.State.OK, RunResult.State.OUTSIDE);
        try (RunJournal journal = open()) {
            Experiment experiment = Experiment.load(folder.resolve("e.yaml"));
            assertThat(journal.dropped()).isEmpty();
            assertThat(journal.kept()).isEqualTo(2);
            assertThat(journal.earlier())
                    .isEqualTo(
                            Map.of(
                                    0,
                                    result(experiment, 0, RunResult.State.OK),
                                    1,
                                    result(experiment, 1, RunResult.State.OUTSIDE)));
        }
    }

    @Test
    void aFailedRunIsMadeAgain() throws Exception {
        write(RunResult.State.OK, RunResult.State.FAILED, RunResult.State.OK);
        try (RunJournal journal = open()) {
            assertThat(journal.earlier()).containsOnlyKeys(0, 2);
        }
    }

    /** A process may be killed, and a machine may lose power, at any byte of the file. */
    @Test
    void eachBeginningOfTheFileContainsTheRunsOfItsCompleteLines() throws Exception {
        write(RunResult.State.OK, RunResult.State.OK, RunResult.State.OK);
        byte[] whole = Files.readAllBytes(file());
        for (int length = 0; length <= whole.length; length += length < 200 ? 1 : 37) {
            byte[] part = Arrays.copyOf(whole, length);
            Files.write(file(), part);
            String complete = new String(part, StandardCharsets.UTF_8);
            complete = complete.substring(0, complete.lastIndexOf('\n') + 1);
            int runs = (int) complete.lines().filter(line -> line.contains("stateHash")).count();
            try (RunJournal journal = open()) {
                assertThat(journal.earlier()).as("%d bytes", length).hasSize(runs);
                assertThat(journal.dropped()).isEmpty();
            }
        }
        byte[] damaged = whole.clone();
        damaged[whole.length / 2] ^= 1;
        Files.write(file(), damaged);
        try (RunJournal journal = open()) {
            assertThat(journal.earlier().size()).isLessThan(3);
        }
    }

    @Test
    void runsAfterATornLineAreKept() throws Exception {
        write(RunResult.State.OK);
        byte[] one = Files.readAllBytes(file());
        Files.write(file(), Arrays.copyOf(one, one.length + 5));
        try (RunJournal journal = open()) {
            Experiment experiment = Experiment.load(folder.resolve("e.yaml"));
            journal.add(result(experiment, 3, RunResult.State.OK));
        }
        try (RunJournal journal = open()) {
            assertThat(journal.earlier()).containsOnlyKeys(0, 3);
        }
    }

    @Test
    void changedFilesAndLawsAreNamed() throws Exception {
        write(RunResult.State.OK);
        byte[] journal = Files.readAllBytes(file());
        requireDropped("shipped/wind.law", "law wind: two", journal, "the law wind has changed");
        requireDropped("world.yaml", "\n", journal, "the file world.yaml has changed");
        requireDropped("e.yaml", "\n", journal, "the file e.yaml has changed");
        Files.delete(folder.resolve("shipped/wind.law"));
        Files.write(file(), journal);
        try (RunJournal opened = open()) {
            assertThat(opened.dropped()).hasValue("the law wind is missing");
        }
    }

    private void requireDropped(String name, String more, byte[] journal, String reason)
            throws Exception {
        Path changed = folder.resolve(name);
        String before = Files.readString(changed);
        Files.writeString(changed, before + more);
        Files.write(file(), journal);
        try (RunJournal opened = open()) {
            assertThat(opened.dropped()).hasValue(reason);
            assertThat(opened.earlier()).isEmpty();
            assertThat(opened.kept()).isZero();
        }
        assertThat(file()).doesNotExist();
        Files.writeString(changed, before);
        Files.write(file(), journal);
        try (RunJournal opened = open()) {
            assertThat(opened.earlier()).hasSize(1);
        }
    }

    @Test
    void theFolderBelongsToOneCommandAndOneExperiment() throws Exception {
        try (RunJournal _ = open()) {
            assertThatThrownBy(this::open)
                    .isInstanceOf(IOException.class)
                    .hasMessageContaining(file().toString())
                    .hasMessageContaining("another command writes results");
        }
        assertThat(file()).doesNotExist();
        write(RunResult.State.OK);
        Path experiment = folder.resolve("e.yaml");
        Files.writeString(experiment, Files.readString(experiment).replace("name: e", "name: f"));
        assertThatThrownBy(this::open).hasMessageContaining("runs of the experiment e, expected f");
        Files.delete(file());
        Files.createSymbolicLink(file(), folder.resolve("elsewhere"));
        assertThatThrownBy(this::open).hasMessageContaining("a symbolic link");
        assertThat(folder.resolve("elsewhere")).doesNotExist();
    }
}
