// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import reve.core.unit.Unit;
import reve.core.world.ActionCall;
import reve.core.world.Parameter;
import reve.core.world.WorldEvent;

import java.util.List;
import java.util.Map;

/** Actions in Java that tests find on the class path. */
public final class TestActions {
    private TestActions() {}

    /** Moves its item up by a number of metres. */
    public static final class Levitate implements ActionProvider {
        @Override
        public String name() {
            return "test.levitate";
        }

        @Override
        public String doc() {
            return "Moves it up.";
        }

        @Override
        public List<Parameter> parameters() {
            return List.of(Parameter.number("by", 1, Unit.parse("m"), "").within(0, 5));
        }

        @Override
        public List<Effect> decide(ActionCall call) {
            double[] to = call.target().physical().location();
            to[1] += call.arguments().number("by");
            return List.of(
                    new Effect.SetLocation(Subject.ITEM, new Operand.Numbers(to, Unit.parse("m"))),
                    new Effect.Raise("up", "levitate"));
        }
    }

    /** Breaks every rule of actions. Each way of calling it breaks one rule. */
    public static final class Broken implements ActionProvider {
        @Override
        public String name() {
            return "test.broken";
        }

        @Override
        public String doc() {
            return "";
        }

        @Override
        public List<Parameter> parameters() {
            return List.of(Parameter.text("how", ""));
        }

        @Override
        public List<Effect> decide(ActionCall call) {
            Effect raise = new Effect.Raise("half", "break");
            return switch (call.arguments().text("how")) {
                case "throw" -> throw new IllegalStateException("out of order");
                case "recurse" -> decide(call);
                case "symbol" -> {
                    call.target().semantic().set("broken", true);
                    yield List.of();
                }
                case "physics" -> {
                    call.target().physics().set("mass", 99);
                    yield List.of();
                }
                case "remove" -> {
                    call.world().remove(call.target().id());
                    yield List.of();
                }
                case "event" -> {
                    call.world().raise(new WorldEvent(call.frame(), "x", Map.of()));
                    yield List.of();
                }
                case "numbers" ->
                        List.of(
                                raise,
                                new Effect.SetProperty(
                                        "velocity",
                                        new Operand.Numbers(new double[] {1}, Unit.parse("m/s"))));
                case "infinite" ->
                        List.of(
                                raise,
                                new Effect.SetLocation(
                                        Subject.ITEM,
                                        new Operand.Numbers(
                                                new double[] {1 / 0.0, 0, 0}, Unit.parse("m"))));
                case "unit" ->
                        List.of(
                                raise,
                                new Effect.SetProperty(
                                        "mass",
                                        new Operand.Numbers(new double[] {1}, Unit.parse("m"))));
                case "twice" -> List.of(raise, raise);
                default ->
                        List.of(
                                raise,
                                new Effect.SetProperty(
                                        "no-such",
                                        new Operand.Numbers(new double[] {1}, Unit.ONE)));
            };
        }
    }
}
