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

import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.List;
import java.util.Map;

/** What is too heavy for a body, as the agent of this body perceives it and others do not. */
class TooHeavyIT {
    /** The child lifts 40 N, the adult 0.1 kN, the blind robot anything. */
    private static final String WORLD =
            """
            reve: 1
            name: attic
            laws: [newton_motion]
            constants: {gravity: [0, -9, 0]}
            agents: {bodies: [child, adult, bob, robot]}
            symbols: {strength: {type: number, unit: N}}
            classes: {person: {semantic: {strength: 40 N}}}
            items:
              - {name: child, physical: {shape: sphere, radius: 0.1}, semantic: {class: person}}
              - name: adult
                physical: {shape: sphere, radius: 0.1, location: [0, 0, 1]}
                semantic: {class: person, strength: 0.1 kN}
                sensors: {eyes: {range: 5}, slow: {every: 3, aspects: [semantic], range: 5}}
                access: {tire: {effects: [{symbol: strength, to: 30}]}}
              - name: bob
                physical: {shape: sphere, radius: 0.1, location: [0, 0, 2]}
                semantic: {class: person}
                sensors: {eyes: {symbols: [class]}, hands: {symbols: [tooHeavy], touch: true, range: 3}}
              - {name: robot, physical: {shape: sphere, radius: 0.1, location: [0, 0, 3]}}
              - {name: book, physical: {shape: box, size: [0.2, 0.2, 0.2], location: [1, 0, 0]}, physics: {mass: 4 kg}}
              - name: chest
                physical: {shape: box, size: [0.4, 0.4, 0.4], location: [2, 0, 0]}
                physics: {mass: 5 kg}
                access: {fill: {effects: [{set: physics.mass, to: 12}]}, empty: {effects: [{set: physics.mass, to: 4.4}]}}
              - {name: safe, physical: {shape: box, size: [1, 1, 1], location: [20, 0, 0]}, physics: {mass: 500 kg}}
              - {name: wall, physical: {shape: box, size: [1, 1, 1], location: [-2, 0, 0]}}
              - {name: pillar, physical: {shape: box, size: [1, 1, 1], location: [-4, 0, 0]}, physics: {mass: 0}}
              - {name: trunk, physical: {shape: box, size: [1, 1, 1], location: [0, 2, 0]}, semantic: {tooHeavy: perhaps}, physics: {mass: 99 kg}}
            """;

    @TempDir private Path folder;

    private Server serve(String text) throws Exception {
        Path file = Files.writeString(folder.resolve("world.yaml"), text);
        return Server.start(
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
    }

    private static AgentClient join(Server server, String name, boolean relations)
            throws Exception {
        LockStep pace = LockStep.every(1).withDeadline(Duration.ofSeconds(300));
        return Agents.join(
                Integer.parseInt(server.port()),
                Join.as(name)
                        .withBody(name)
                        .withEncoding(relations ? Encoding.MESSAGEPACK : Encoding.JSON)
                        .withLockStep(relations ? pace.withRelations() : pace));
    }

    /**
     * Returns the names of the items that the agent perceives as too heavy, in alphabetic order.
     */
    private static List<String> tooHeavy(Perception perception) {
        return perception.items().stream()
                .filter(item -> Boolean.TRUE.equals(item.symbols().get("tooHeavy")))
                .map(Perception.Item::name)
                .sorted()
                .toList();
    }

    @Test
    void eachAgentPerceivesWhatIsTooHeavyForItsOwnBody() throws Exception {
        try (Server server = serve(WORLD);
                AgentClient child = join(server, "child", false);
                AgentClient adult = join(server, "adult", true);
                AgentClient bob = join(server, "bob", false);
                AgentClient robot = join(server, "robot", true)) {
            Perception first = child.observe();
            assertThat(tooHeavy(first)).containsExactly("chest", "safe");
            assertThat(first.find("book").orElseThrow().symbols())
                    .as("36 N")
                    .containsOnlyKeys("name", "class", "dimensions");
            assertThat(first.find("trunk").orElseThrow().symbols())
                    .as("a symbol of the designer")
                    .containsEntry("tooHeavy", "perhaps");
            assertThat(tooHeavy(adult.observe())).isEmpty();
            assertThat(tooHeavy(robot.observe())).isEmpty();
            Perception touched = bob.observe();
            assertThat(tooHeavy(touched)).containsExactly("chest");
            assertThat(touched.find("chest").orElseThrow().symbols())
                    .containsOnlyKeys("class", "tooHeavy");
            assertThat(touched.find("safe").orElseThrow().symbols())
                    .as("seen, but not touched")
                    .containsOnlyKeys("class");
        }
    }

    @Test
    void theSymbolFollowsTheWeightAndTheStrength() throws Exception {
        try (Server server = serve(WORLD);
                AgentClient child = join(server, "child", true)) {
            assertThat(tooHeavy(child.observe())).containsExactly("chest", "safe");
            Perception emptied = child.step(Act.of("chest", "empty", Map.of()));
            assertThat(tooHeavy(emptied)).containsExactly("safe");
            assertThat(emptied.find("chest").orElseThrow().symbols())
                    .containsKey("near")
                    .doesNotContainKey("tooHeavy");
            Perception filled = child.step(Act.of("chest", "fill", Map.of()));
            assertThat(tooHeavy(filled)).containsExactly("chest", "safe");
            assertThat(filled.find("chest").orElseThrow().symbols()).containsKey("near");
        }
    }

    @Test
    void aTiredBodyLiftsLess() throws Exception {
        try (Server server = serve(WORLD);
                AgentClient adult = join(server, "adult", false)) {
            assertThat(tooHeavy(adult.observe())).isEmpty();
            assertThat(tooHeavy(adult.step(Act.of("adult", "tire", Map.of()))))
                    .containsExactly("book", "chest");
        }
    }

    @Test
    void aWorldWithoutAStrengthInNewtonsHasNoSuchSymbol() throws Exception {
        String other = WORLD.replace("unit: N}", "unit: kg}").replaceAll("40 N|0.1 kN", "1 kg");
        try (Server server = serve(other);
                AgentClient child = join(server, "child", false)) {
            assertThat(tooHeavy(child.observe())).isEmpty();
        }
    }
}
