// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.rule.Rule;

import java.util.ArrayList;
import java.util.Collections;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.Set;
import java.util.stream.Collectors;

/** Changes of rules lead from the rules of the world file to those of the running world. */
class RuleChangesTest {
    private static final long SEED = 20261130;

    /** Number of series of changes. 200 in a long run. */
    private static final int SERIES = Integer.getInteger("reve.test.rule.series", 30);

    private final List<String> problems = new ArrayList<>();

    private static WorldDescription world(String rules) throws WorldFileException {
        return WorldFileTest.parse("reve: 1\nname: w\nrules: {" + rules + "}\n");
    }

    private static EditReader reader(WorldDescription world) {
        return new EditReader(world.prototype());
    }

    /** Returns the rules as a world file has them, in their order. */
    private static List<String> texts(List<Rule> rules) {
        return rules.stream().map(rule -> rule.symbol() + ": " + WorldWriter.rule(rule)).toList();
    }

    private List<Rule> repeated(WorldDescription file, RuleChanges changes) {
        return reader(file).rules(file.rules(), changes, problems::add);
    }

    private static Set<String> symbols(List<Rule> rules) {
        return rules.stream().map(Rule::symbol).collect(Collectors.toSet());
    }

    @Test
    void anyChangesLeadToTheRulesOfTheWorldInTheirOrder() throws Exception {
        Random random = new Random(SEED);
        for (int run = 0; run < SERIES; run++) {
            WorldDescription file = world("a: '1.0', b: {is: '2.0', doc: Two.}, c: '3.0'");
            Set<String> inFile = symbols(file.rules());
            List<Rule> now = file.rules();
            RuleChanges sinceFile = RuleChanges.NONE;
            for (int step = 0; step < 12; step++) {
                List<Rule> next = changed(file, now, random);
                List<RuleChanges.Change> made = RuleChanges.between(now, next);
                assertThat(texts(reader(file).rules(now, new RuleChanges(made), problems::add)))
                        .isEqualTo(texts(next));
                sinceFile = sinceFile.with(made, inFile::contains);
                now = next;
                assertThat(texts(repeated(file, sinceFile)))
                        .as("run %d, step %d", run, step)
                        .isEqualTo(texts(now));
                assertThat(sinceFile.changes())
                        .as("only rules that the file or the world has")
                        .allMatch(
                                change ->
                                        change.rule().isPresent()
                                                || inFile.contains(change.symbol()));
            }
        }
        assertThat(problems).isEmpty();
    }

    /** Makes changes like a message, or puts the rules into any order, like a Java program. */
    private static List<Rule> changed(WorldDescription file, List<Rule> now, Random random)
            throws Exception {
        if (random.nextInt(5) == 0) {
            List<Rule> shuffled = new ArrayList<>(now);
            Collections.shuffle(shuffled, random);
            return shuffled;
        }
        Map<String, Optional<String>> changes = new LinkedHashMap<>();
        for (int i = random.nextInt(3); i >= 0; i--) {
            String symbol = String.valueOf((char) ('a' + random.nextInt(6)));
            changes.put(
                    symbol,
                    random.nextInt(3) == 0
                            ? Optional.empty()
                            : Optional.of("\"" + random.nextInt(3) + ".0\""));
        }
        return reader(file).rules(now, changes);
    }

    @Test
    void aRuleThatDidNotChangeComesFromTheWorldFileAlsoAfterTheFileWasEdited() throws Exception {
        WorldDescription file = world("a: '1.0', b: '2.0', c: '3.0'");
        Map<String, Optional<String>> message = new LinkedHashMap<>();
        message.put("b", Optional.empty());
        message.put("c", Optional.of("\"physics.mass > 5.0\""));
        message.put("late", Optional.of("{\"is\": \"semantic.c\", \"class\": \"toy\"}"));
        List<Rule> now = reader(file).rules(file.rules(), message);
        RuleChanges changes =
                RuleChanges.NONE.with(
                        RuleChanges.between(file.rules(), now), symbols(file.rules())::contains);
        WorldDescription edited = world("a: '9.0', b: '8.0', c: '7.0', d: '6.0'");
        assertThat(texts(repeated(edited, changes)))
                .containsExactly(
                        "a: 9.0",
                        "c: physics.mass > 5.0",
                        "d: 6.0",
                        "late: {is=semantic.c, class=toy}");
        assertThat(problems).isEmpty();
    }

    @Test
    void aRuleThatIsRemovedAndSetAgainIsTheLastOne() throws Exception {
        WorldDescription file = world("a: '1.0', b: '2.0'");
        List<Rule> without = reader(file).rules(file.rules(), Map.of("a", Optional.empty()));
        List<Rule> again = reader(file).rules(without, Map.of("a", Optional.of("\"semantic.b\"")));
        RuleChanges changes =
                RuleChanges.NONE
                        .with(RuleChanges.between(file.rules(), without), any -> true)
                        .with(RuleChanges.between(without, again), any -> true);
        assertThat(texts(repeated(file, changes))).containsExactly("b: 2.0", "a: semantic.b");
        assertThat(problems).isEmpty();
    }

    @Test
    void aChangeThatDoesNotFitTheWorldFileIsLeftOutAndNamed() throws Exception {
        WorldDescription file = world("a: '1.0', b: '2.0'");
        List<RuleChanges.Change> changes =
                List.of(
                        new RuleChanges.Change("a", Optional.of("\"semantic.b\""), false),
                        new RuleChanges.Change("x", Optional.of("\"physics.mas > 1\""), true),
                        new RuleChanges.Change("y", Optional.of("{\"java\": \"gone\"}"), true),
                        new RuleChanges.Change("z", Optional.of("no JSON {"), true),
                        new RuleChanges.Change("good", Optional.of("\"4.0\""), true));
        assertThat(new HashSet<>(texts(repeated(file, new RuleChanges(changes)))))
                .containsExactlyInAnyOrder("b: 2.0", "good: 4.0");
        assertThat(problems).hasSize(4).allMatch(text -> text.contains("continues without this"));
        assertThat(problems.toString())
                .contains("rule a: ", "comes later", "rule x: ", "rule y: ", "gone", "rule z: ");
    }
}
