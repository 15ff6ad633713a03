// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;

import reve.core.Seed;
import reve.core.unit.Unit;
import reve.core.world.Arguments;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Parameter;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.lang.management.ManagementFactory;
import java.util.ArrayList;
import java.util.Collections;
import java.util.List;
import java.util.Random;
import java.util.function.IntSupplier;

/** Expressions that are as costly as their authors could make them. */
@Timeout(120)
class HostileExpressionsTest {
    private static final WorldPrototype PROTOTYPE = WorldPrototype.standard("si-f64");

    /**
     * An expression that loops over a simple condition until it has too many steps. It takes 2 to 6
     * ms on usual machines.
     */
    private static final String ORDINARY =
            "(range+range).all(a,(range+range).all(b,size(label)>1))";

    /** Maximum duration of the ordinary expression: the time of a frame at 60 frames per second. */
    private static final double MAX_MILLISECONDS = 1000.0 / 60;

    /** Maximum duration of an expression, as a multiple of the duration of the ordinary one. */
    private static final double MAX_DURATION = 3;

    private static final double MAX_MILLISECONDS_TO_COMPILE = 250;
    private static final double MAX_MEBIBYTES = 16;

    /**
     * Number of attempts. The compiler, or other work on the machine, may slow down some of them.
     */
    private static final int ATTEMPTS = 50;

    /** Operations that enlarge a value. */
    private static final List<String> GROWTH =
            List.of(
                    ".map(x,[x,x])",
                    ".map(x,x+x)",
                    ".map(x,[x,x,x])",
                    ".map(x,{'a':x,'b':x})",
                    ".map(x,[x]+[x])",
                    ".map(x,[[x]])",
                    ".map(x,[x,x]==[x,x])",
                    ".filter(x,x==x)",
                    ".map(x,{x:x})");

    private static final List<String> LISTS =
            List.of(
                    "[label]",
                    "[[1]]",
                    "semantic.tags",
                    "range",
                    "(range+range)",
                    "semantic.near",
                    "[semantic,semantic]",
                    "[physics]");

    /** Conditions that are costly, or whose failure is caught. */
    private static final List<String> CONDITIONS =
            List.of(
                    "1/0>1||true",
                    "label==label",
                    "label.contains('ab')",
                    "semantic.text.contains(label)",
                    "semantic==semantic",
                    "physics==physics",
                    "label.matches('^(a+)+$')",
                    "semantic.text.matches('a{900}')",
                    "semantic.text.matches('(a|b|ab)*c')",
                    "semantic.missing==1||true",
                    "label in semantic.tags",
                    "semantic.tags==semantic.tags",
                    "size(label)>1",
                    "size(semantic)>1",
                    "semantic.all(k,size(semantic)>1)",
                    "actor==actor",
                    "[semantic,semantic]==[semantic,semantic]",
                    "string(1e300)!=label",
                    "norm(range)>1",
                    "dyn(label)+1==2||true",
                    "norm(semantic.tags)>1||true",
                    "size(semantic.near)>=0",
                    "range.exists_one(c,c>1)",
                    "double(label)>1||true",
                    "[1,2,3][dyn(label)]==1||true",
                    "dyn(1)||dyn(2)||true",
                    "(dyn(1)?true:false)||true",
                    "has(semantic.x.y)||true",
                    "9223372036854775807+1>0||true",
                    "int(1e300)>0||true",
                    "math.greatest(range)>0||true",
                    "label+label+label+label!=''");

    private static final List<String> LOOPS =
            List.of(
                    "%s",
                    "(range+range).all(a,(range+range).all(b,%s))",
                    "range.exists(a,range.exists_one(b,%s))",
                    "range.map(a,range.filter(b,%s))!=[]");

    private final OffHeapArena arena = new OffHeapArena();
    private final World world = new World("test", PROTOTYPE, arena);
    private final Item ball =
            world.add(
                    ItemDefinition.named("ball")
                            .at(1, 2, 3)
                            .symbol("text", "a".repeat(4096))
                            .symbol("tags", Collections.nCopies(64, "tag"))
                            .physics("mass", 2)
                            .physics("velocity", 3, 0, 4)
                            .build());
    private final Scope scope =
            Scope.ofAction(
                    PROTOTYPE,
                    "body",
                    List.of(
                            Parameter.text("label", ""),
                            Parameter.number("range", 16, Unit.ONE, "")));

    private double ordinaryMilliseconds;

    @AfterEach
    void free() {
        arena.close();
    }

    private Bindings bindings() {
        return scope.bindings()
                .of(ball)
                .withItem("actor", ball)
                .with("label", "a".repeat(Arguments.MAX_TEXT_LENGTH - 1) + "b")
                .with("range", Collections.nCopies(16, 1.0));
    }

    private static String filled(String begin, String repeated, String end) {
        int room = Language.MAX_LENGTH - begin.length() - end.length();
        return begin + repeated.repeat(room / repeated.length()) + end;
    }

    private static List<String> corpus(Random random) {
        List<String> all = new ArrayList<>();
        for (String list : LISTS) {
            for (String growth : GROWTH) {
                for (int times : new int[] {1, 9, 15}) {
                    all.add(list + growth.repeat(times));
                }
                all.add(filled(list, growth, ""));
            }
        }
        for (String condition : CONDITIONS) {
            for (String loop : LOOPS) {
                all.add(loop.replace("%s", condition));
                String[] parts = loop.split("%s", -1);
                all.add(filled(parts[0] + condition, "&&(" + condition + ")", parts[1]));
            }
        }
        for (String repeated : List.of("label+label|", "1+1|", "semantic.tags+semantic.tags|")) {
            String one = repeated.substring(0, repeated.indexOf('+'));
            all.add(filled(one, "+" + one, ""));
        }
        for (String[] around :
                new String[][] {
                    {"(", ")"},
                    {"[", "]"},
                    {"-(", ")"},
                    {"!", ""},
                    {"{'a':", "}"},
                    {"(true?", ":2)"},
                    {"[1].map(x,", ")"}
                }) {
            for (int times : new int[] {20, 60, 120}) {
                all.add(around[0].repeat(times) + "true" + around[1].repeat(times));
            }
        }
        for (int i = 0; i < 60; i++) {
            all.add(any(random));
        }
        return all;
    }

    /** Returns a value of maximum length. */
    private static String any(Random random) {
        IntSupplier choice = () -> random.nextInt(7);
        String text = one(LISTS, random);
        while (true) {
            String longer =
                    switch (choice.getAsInt()) {
                        case 0 -> text + "+" + one(LISTS, random);
                        case 1 -> "[" + text + "," + one(LISTS, random) + "]";
                        case 2 -> text + ".filter(x," + one(CONDITIONS, random) + ")";
                        case 3 -> one(LISTS, random) + ".map(y," + text + ")";
                        case 4 -> "(" + one(CONDITIONS, random) + "?" + text + ":" + text + ")";
                        default -> text + one(GROWTH, random);
                    };
            if (longer.length() > Language.MAX_LENGTH) {
                return text;
            }
            text = longer;
        }
    }

    private static String one(List<String> of, Random random) {
        return of.get(random.nextInt(of.size()));
    }

    @Test
    void anyExpressionEndsSoonAndTakesLittleMemory() throws Exception {
        long seed = Seed.of("hostile expressions");
        List<String> corpus = corpus(new Random(seed));
        assertThat(corpus).hasSizeGreaterThan(200);
        measureOrdinary(seed);
        int evaluated = 0;
        int exceeded = 0;
        for (String text : corpus) {
            Expression expression = compiled(text, seed);
            if (expression != null) {
                evaluated++;
                exceeded += evaluate(expression, seed) ? 1 : 0;
            }
        }
        assertThat(evaluated).isGreaterThan(200);
        assertThat(exceeded).isGreaterThan(50);
    }

    private Expression compiled(String text, long seed) {
        Expression expression = null;
        double milliseconds = Double.MAX_VALUE;
        for (int i = 0; i < ATTEMPTS && milliseconds > MAX_MILLISECONDS_TO_COMPILE; i++) {
            long start = threads().getCurrentThreadCpuTime();
            try {
                expression = scope.compile(text);
            } catch (ExpressionException refused) {
                assertThat(refused.getMessage()).isNotBlank();
            }
            milliseconds = (threads().getCurrentThreadCpuTime() - start) / 1e6;
        }
        assertThat(milliseconds)
                .as("milliseconds to compile, seed %d: %s", seed, text)
                .isLessThan(MAX_MILLISECONDS_TO_COMPILE);
        return expression;
    }

    /**
     * @return whether it took too many steps
     */
    private boolean evaluate(Expression expression, long seed) throws Exception {
        Cost cost = cost(expression, seed, MAX_DURATION * ordinaryMilliseconds);
        if (cost.milliseconds > MAX_DURATION * ordinaryMilliseconds) {
            measureOrdinary(seed); // the machine may have become slower
        }
        assertThat(cost.milliseconds / ordinaryMilliseconds)
                .as("duration / ordinary duration, seed %d: %s", seed, expression)
                .isLessThan(MAX_DURATION);
        assertThat(cost.outcome.length()).isLessThan(Language.MAX_LENGTH + 400);
        return cost.outcome.contains("takes more than 20000 steps");
    }

    private void measureOrdinary(long seed) throws Exception {
        Cost cost = cost(scope.compile(ORDINARY), seed, 0);
        assertThat(cost.outcome).contains("takes more than 20000 steps");
        assertThat(cost.milliseconds).as("ordinary duration [ms]").isLessThan(MAX_MILLISECONDS);
        ordinaryMilliseconds = cost.milliseconds;
    }

    /** Least processor time of several attempts, and the message of an expression that failed. */
    private record Cost(double milliseconds, String outcome) {}

    /**
     * @param enough time at which no further attempts are made [ms]
     */
    private Cost cost(Expression expression, long seed, double enough) {
        double milliseconds = Double.MAX_VALUE;
        String outcome = "";
        for (int i = 0; i < ATTEMPTS && milliseconds > enough; i++) {
            long bytes = threads().getCurrentThreadAllocatedBytes();
            long start = threads().getCurrentThreadCpuTime();
            try {
                expression.evaluate(bindings());
            } catch (EvaluationException failed) {
                outcome = failed.getMessage();
            }
            milliseconds =
                    Math.min(milliseconds, (threads().getCurrentThreadCpuTime() - start) / 1e6);
            assertThat((threads().getCurrentThreadAllocatedBytes() - bytes) / 1048576.0)
                    .as("MiB, seed %d: %s", seed, expression)
                    .isLessThan(MAX_MEBIBYTES);
        }
        return new Cost(milliseconds, outcome);
    }

    private static com.sun.management.ThreadMXBean threads() {
        return (com.sun.management.ThreadMXBean) ManagementFactory.getThreadMXBean();
    }

    @Test
    void evaluationOfTooManyStepsIsRefusedByNameAndTheNextOneIsNot() throws Exception {
        Expression grows = scope.compile("size([label]" + ".map(x, [x, x])".repeat(16) + ") > 0");

        assertThat(
                        catchThrowableOfType(
                                EvaluationException.class, () -> grows.evaluate(bindings())))
                .hasMessage(
                        "`"
                                + grows
                                + "`: takes more than 20000 steps, which no expression may: let it"
                                + " loop over less, or over shorter texts and lists");
        assertThat(scope.compile("size(label)").evaluate(bindings())).isEqualTo(1024.0);
    }

    @Test
    void limitCannotBeMadeGoodByAnAlternative() throws Exception {
        Expression grows =
                scope.compile("true || size([label]" + ".map(x, [x, x])".repeat(16) + ") > 0");
        Expression hides =
                scope.compile("size([label]" + ".map(x, [x, x])".repeat(15) + ") > 0 || true");

        assertThat(grows.evaluate(bindings())).isEqualTo(true);
        assertThat(
                        catchThrowableOfType(
                                EvaluationException.class, () -> hides.evaluate(bindings())))
                .hasMessageContaining("steps");
    }

    @Test
    void numberOfStepsIsTheSameOnEveryMachine() throws Exception {
        Expression loops = scope.compile("range.all(x, range.all(y, label + label != ''))");
        List<Integer> refused = new ArrayList<>();
        for (int length = 0; length <= Arguments.MAX_TEXT_LENGTH; length += 32) {
            try {
                loops.evaluate(bindings().with("label", "a".repeat(length)));
            } catch (EvaluationException exceeded) {
                refused.add(length);
            }
        }

        assertThat(refused).first().isEqualTo(544);
    }
}
