// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.Act;
import reve.agent.AgentClient;
import reve.agent.Encoding;
import reve.agent.Join;
import reve.agent.LockStep;
import reve.agent.Perception;
import reve.tests.Reve.Outcome;

import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.List;
import java.util.Map;

/** Classes of items, as agents perceive them and as commands report them. */
class ClassesIT {
    private static final String WORLD =
            """
            reve: 1
            name: pantry
            laws: [newton_motion]
            agents: {bodies: [ada, bob]}
            classes:
              vessel: {semantic: {holds: liquid}}
              cup: {is: vessel, semantic: {fragile: true}}
            rules:
              full: {is: semantic.level > 0.5, class: vessel}
            items:
              - {name: ada, physical: {shape: sphere, radius: 0.1}, physics: {velocity: [0, 0, 0.1], mass: 1}}
              - name: bob
                physical: {shape: sphere, radius: 0.1, location: [0, 0, 1]}
                sensors: {eyes: {symbols: [classes]}}
              - name: mug
                physical: {shape: sphere, radius: 0.1, location: [0, 0, 2]}
                semantic: {class: cup, level: 0.9}
                access: {drop: {effects: [{symbol: class, to: shard}]}}
              - {name: stone, physical: {shape: sphere, radius: 0.1, location: [0, 0, 3]}}
            """;

    @TempDir private Path folder;

    private static AgentClient join(Server server, String name, Encoding encoding)
            throws Exception {
        return Agents.join(
                Integer.parseInt(server.port()),
                Join.as(name)
                        .withBody(name)
                        .withEncoding(encoding)
                        .withLockStep(LockStep.every(1).withDeadline(Duration.ofSeconds(300))));
    }

    private static Perception.Item mug(Perception perception) {
        return perception.find("mug").orElseThrow();
    }

    @Test
    void agentsPerceiveClassesAndInheritedSymbolsUntilTheClassChanges() throws Exception {
        Path file = Files.writeString(folder.resolve("world.yaml"), WORLD);
        try (Server server =
                        Server.start(
                                folder,
                                "serve",
                                file.toString(),
                                "--port",
                                "0",
                                "--json",
                                "--deadline",
                                "300",
                                "--waiting",
                                "off");
                AgentClient ada = join(server, "ada", Encoding.JSON)) {
            Perception first = ada.observe();
            assertThat(mug(first).symbols())
                    .containsEntry("class", "cup")
                    .containsEntry("classes", List.of("cup", "vessel", "body"))
                    .containsEntry("holds", "liquid")
                    .containsEntry("fragile", true)
                    .containsEntry("full", true);
            assertThat(mug(first).isA("vessel")).isTrue();
            assertThat(mug(first).isA("body")).isTrue();
            assertThat(mug(first).isA("shard")).isFalse();
            assertThat(first.find("stone").orElseThrow().symbols())
                    .containsOnlyKeys("name", "class", "dimensions");
            assertThat(first.find("stone").orElseThrow().isA("vessel")).isFalse();

            Perception after = ada.step(Act.of("mug", "drop", Map.of()));
            assertThat(mug(after).symbols())
                    .containsOnlyKeys("name", "class", "dimensions", "level");
            assertThat(mug(after).isA("vessel")).isFalse();
        }
    }

    @Test
    void aSensorMayPerceiveNothingButClasses() throws Exception {
        Path file = Files.writeString(folder.resolve("world.yaml"), WORLD);
        try (Server server =
                        Server.start(
                                folder,
                                "serve",
                                file.toString(),
                                "--port",
                                "0",
                                "--json",
                                "--deadline",
                                "300",
                                "--waiting",
                                "off");
                AgentClient bob = join(server, "bob", Encoding.MESSAGEPACK)) {
            Perception perception = bob.observe();
            assertThat(mug(perception).symbols())
                    .containsOnlyKeys("classes")
                    .containsEntry("classes", List.of("cup", "vessel", "body"));
            assertThat(mug(perception).isA("vessel")).isTrue();
        }
    }

    @Test
    void checkFindsMistakesAndWarnsOfOtherClasses() throws Exception {
        Path file = folder.resolve("world.yaml");
        Files.writeString(file, WORLD);
        assertThat(Reve.run("check", file.toString(), "--strict").err()).isEmpty();

        Files.writeString(file, WORLD.replace("class: cup,", "class: cop,"));
        Outcome strict = Reve.run("check", file.toString(), "--strict");
        assertThat(strict.code()).isEqualTo(3);
        assertThat(strict.err())
                .contains(
                        "world.yaml:17:23: warning: class: `cop` is not one of the classes that the"
                                + " world declares; did you mean `cup`?");

        Files.writeString(file, WORLD.replace("is: vessel,", "is: vesel,"));
        Outcome wrong = Reve.run("check", file.toString());
        assertThat(wrong.code()).isEqualTo(3);
        assertThat(wrong.err())
                .contains(
                        "world.yaml:7:13: is: there is no class or kind `vesel`; did you mean"
                                + " `vessel`?");
    }

    @Test
    void aRecordingRepeatsTheClasses() throws Exception {
        Path file = Files.writeString(folder.resolve("world.yaml"), WORLD);
        String log = folder.resolve("run.log").toString();
        Outcome run = Reve.run("run", file.toString(), "--seconds", "0.2", "--record", log);
        assertThat(run.code()).as(run.err()).isZero();
        assertThat(Reve.run("replay", log).code()).isZero();
        Path out = folder.resolve("out.jsonld");
        Outcome export = Reve.run("export", log, "--json-ld", out.toString());
        assertThat(export.code()).as(export.err()).isZero();
        assertThat(Files.readString(out)).contains("\"class:cup\"", "\"symbol:fragile\":true");
    }
}
