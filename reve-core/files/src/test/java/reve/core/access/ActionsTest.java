// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.file.ItemWriter;
import reve.core.file.WorldFile;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.world.Action;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Arguments;
import reve.core.world.EventBudget;
import reve.core.world.ForceBudget;
import reve.core.world.FrameControl;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.ItemQuota;
import reve.core.world.OffHeapArena;
import reve.core.world.SymbolBudget;
import reve.core.world.World;
import reve.core.world.WorldEvent;

import java.nio.charset.StandardCharsets;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** Effects and refusals of the actions of world files. */
class ActionsTest {
    private static final String WORLD =
            """
            reve: 1
            name: kitchen
            properties: [{name: temperature, kind: body, unit: K}]
            symbols: {limit: {type: number, unit: km/h}}
            prefabs:
              crumb: {physical: {shape: sphere, radius: 1 mm}, physics: {mass: 1 g}}
            items:
              - name: cook
                capabilities: [grip, push]
                physical: {location: [0, 0, 0]}
                semantic: {strength: 3}
                physics: {mass: 70}
              - name: mouse
                physical: {location: [9, 0, 0]}
                physics: {mass: 30 g}
              - name: tray
                physical: {location: [0, 2, 0]}
              - name: pot
                physical: {location: [1, 0, 0]}
                physics: {mass: 2, temperature: 300, velocity: [1, 0, 0]}
                access:
                  heat:
                    needs: [grip]
                    when: [physics.temperature + by < 400, "distance(physical.location, actor.physical.location) < 2"]
                    parameters: {by: {unit: K, min: 0, max: 200}}
                    effects:
                      - {set: physics.temperature, to: $physics.temperature + by}
                      - {symbol: heatedBy, to: $actor.name}
                      - {symbol: limit, to: $5.0}
                      - {raise: heated, with: {kelvin: $physics.temperature + by, hard: true}}
                  slow: {effects: [{set: physics.velocity, to: "$scale(physics.velocity, 0.5)"}]}
                  paint: {parameters: {like: {type: item}}, effects: [{set: physical.colour, to: $like.physical.colour}]}
                  swap: {effects: [{set: physical.location, to: $actor.physical.location}, {item: actor, set: physical.location, to: $physical.location}, {set: physical.orientation, to: [0, 2, 0, 0]}]}
                  thank: {effects: [{item: actor, symbol: thanked, to: $item.name}]}
                  blow: {parameters: {f: {components: 3, unit: kN}}, effects: [{force: $f, for: 0.25 s}]}
                  kick: {effects: [{force: 0 0 5}]}
                  weigh: {parameters: {m: {unit: kg}}, effects: [{set: physics.mass, to: $m}, {raise: weighed}]}
                  mould: {parameters: {m: {components: 3, unit: kg*m^2}}, effects: [{set: physics.inertia, to: $m}]}
                  spill: {parameters: {m: {components: 3, unit: kg*m^2}}, effects: [{create: {name: drop, like: crumb}, with: {physics.inertia: $m}}]}
                  move: {parameters: {to: {components: 3, unit: m}}, effects: [{set: physical.location, to: $to}]}
                  crumble:
                    effects:
                      - create: {name: crumb, like: crumb, semantic: {class: crumb}}
                        with: {physical.location: "$add(physical.location, [0, 1, 0])", physics.velocity: $physics.velocity, semantic.of: $item.name, physical.colour: "#112233"}
                      - create: {name: crumb, like: crumb}
                      - remove: true
                  hopeless: {effects: [{symbol: done, to: true}, {symbol: x, to: $semantic.missing}]}
                  lift: {java: test.levitate, when: physics.mass < 10}
                  break: {java: test.broken}
              - name: cup
                physical: {location: [0, 3, 0]}
                access:
                  take: {needs: [grip], effects: [{attach: actor}]}
                  put: {parameters: {to: {type: item}}, effects: [{attach: to}]}
                  drop: {effects: [{detach: true}, {raise: dropped}]}
                  bin: {effects: [{symbol: gone, to: true}, {remove: true}]}
                  serve: {effects: [{create: {name: lid, parent: tray}}]}
                  trash: {parameters: {what: {type: item}}, effects: [{remove: true, item: what}]}
            """;

    private final OffHeapArena arena = new OffHeapArena();
    private final World world = build();

    private World build() {
        try {
            return WorldFile.parse("kitchen", WORLD.getBytes(StandardCharsets.UTF_8)).build(arena);
        } catch (Exception wrong) {
            throw new AssertionError(wrong);
        }
    }

    @AfterEach
    void free() {
        arena.close();
    }

    private Item item(String name) {
        return world.find(name).orElseThrow();
    }

    private void act(String actor, String item, String action, Map<String, ?> arguments)
            throws ActionRefused {
        Action found = item(item).access().find(action).orElseThrow();
        new ActionCall(world, 1, item(item), world.find(actor), Arguments.check(found, arguments))
                .perform(found);
    }

    /**
     * Asserts the refusal; the world must be unchanged. An action in Java that fails is reported by
     * one event.
     */
    private ActionRefused refusal(String actor, String item, String action, Map<String, ?> given) {
        String before = state();
        int events = world.events().size();
        var refused =
                catchThrowableOfType(ActionRefused.class, () -> act(actor, item, action, given));
        assertThat(refused).isNotNull();
        assertThat(state()).isEqualTo(before);
        List<WorldEvent> raised = world.events().subList(events, world.events().size());
        if (refused.code().equals("action-failed")) {
            assertThat(raised).extracting(WorldEvent::type).containsExactly("fault");
            assertThat(raised.getFirst().fields())
                    .containsEntry("source", "action test.broken")
                    .containsEntry("class", TestActions.Broken.class.getName());
        } else {
            assertThat(raised).isEmpty();
        }
        return refused;
    }

    private String state() {
        var writer = new ItemWriter(world.prototype());
        var state = new StringBuilder(world.forces().active().toString());
        world.items().stream()
                .filter(item -> !item.name().equals("world"))
                .forEach(item -> state.append(writer.write(item.definition())));
        return state.toString();
    }

    @Test
    void valuesAreComputedFromTheWorldAsItWas() throws Exception {
        act("cook", "pot", "heat", Map.of("by", 50));

        assertThat(item("pot").physics().scalar("temperature")).isEqualTo(350);
        assertThat(item("pot").semantic().get("heatedBy")).contains("cook");
        assertThat((double) item("pot").semantic().get("limit").orElseThrow())
                .isCloseTo(18, within(1e-12));
        assertThat(world.events())
                .singleElement()
                .satisfies(
                        event ->
                                assertThat(event.fields())
                                        .containsExactlyInAnyOrderEntriesOf(
                                                Map.of(
                                                        "item", "pot", "action", "heat", "actor",
                                                        "cook", "kelvin", 350.0, "hard", true)));

        act("cook", "pot", "slow", Map.of());
        assertThat(item("pot").physics().vector("velocity")).containsExactly(0.5, 0, 0);
        act("cook", "pot", "swap", Map.of());
        assertThat(item("pot").physical().location()).containsExactly(0, 0, 0);
        assertThat(item("cook").physical().location()).containsExactly(1, 0, 0);
        assertThat(item("pot").physical().orientation()).containsExactly(0, 1, 0, 0);
        act("cook", "pot", "thank", Map.of());
        assertThat(item("cook").semantic().get("thanked")).contains("pot");
    }

    @Test
    void conditionThatDoesNotHoldIsNamedWithWhatWasFound() {
        assertThat(refusal("cook", "pot", "heat", Map.of("by", 150)))
                .hasMessage(
                        "`physics.temperature + by < 400` does not hold: by is 150.0, "
                                + "physics.temperature is 300.0")
                .extracting(ActionRefused::code)
                .isEqualTo("condition-failed");
        item("cook").physical().setLocation(9, 9, 9);
        assertThat(refusal("cook", "pot", "heat", Map.of("by", 1)))
                .hasMessageContaining(
                        "does not hold: actor.physical.location is [9.0, 9.0, 9.0], "
                                + "physical.location is [1.0, 0.0, 0.0]");
    }

    @Test
    void forcesWhoseSumCouldBeInfiniteAreRefused() {
        assertThat(refusal("cook", "pot", "blow", Map.of("f", List.of(1e200, 0, 0))))
                .hasMessage(
                        "found 1.0E203; an action or an edit sets 0 or a magnitude from "
                                + "1.0E-100 to 1.0E100")
                .extracting(ActionRefused::code)
                .isEqualTo("out-of-range");
    }

    @ParameterizedTest
    @ValueSource(doubles = {1e-320, -1e-320, 5e-324, 1e-160, 9e-101, 1.1e100, -1, -1e300})
    void aMassThatLawsCannotComputeWithIsRefused(double mass) {
        assertThat(refusal("cook", "pot", "weigh", Map.of("m", mass)).code())
                .isEqualTo("out-of-range");
    }

    @Test
    void aMassAtItsBoundsIsTaken() throws ActionRefused {
        for (double mass : new double[] {1e-100, 1e100, 0}) {
            act("cook", "pot", "weigh", Map.of("m", mass));
            assertThat(item("pot").physics().scalar("mass")).isEqualTo(mass);
        }
    }

    @ParameterizedTest
    @ValueSource(strings = {"mould", "spill"})
    void inertiaThatNoBodyHasIsRefused(String action) throws ActionRefused {
        assertThat(refusal("cook", "pot", action, Map.of("m", List.of(1, 1, 3))))
                .hasMessageStartingWith("inertia of ")
                .hasMessageEndingWith(
                        " cannot become [1.0, 1.0, 3.0]: no body has moments of 1.0, 1.0 and 3.0"
                                + " kg*m^2; expected none larger than the sum of the two others")
                .extracting(ActionRefused::code)
                .isEqualTo("out-of-range");
        assertThat(refusal("cook", "pot", action, Map.of("m", List.of(1, 1e-160, 1))).code())
                .isEqualTo("out-of-range");
        act("cook", "pot", action, Map.of("m", List.of(1, 1, 2)));
        act("cook", "pot", action, Map.of("m", List.of(0, 0, 3)));
    }

    @Test
    void aPlaceAtASubnormalDistanceIsRefused() {
        assertThat(refusal("cook", "pot", "move", Map.of("to", List.of(0, 1e-160, 0))).code())
                .isEqualTo("out-of-range");
    }

    @Test
    void argumentOutOfRangeIsRefused() {
        assertThat(refusal("cook", "pot", "heat", Map.of("by", 201)))
                .hasMessage("`by` of action heat takes a number in K from 0.0 to 200.0, found 201")
                .extracting(ActionRefused::code)
                .isEqualTo("out-of-range");
    }

    @Test
    void whoLacksACapabilityIsRefusedByName() {
        assertThat(refusal("mouse", "cup", "take", Map.of()))
                .hasMessage("action take of cup needs the capability `grip`; mouse has none")
                .extracting(ActionRefused::code)
                .isEqualTo("not-capable");
        assertThat(refusal("nobody", "cup", "take", Map.of()).code()).isEqualTo("no-actor");
        assertThat(refusal("nobody", "pot", "thank", Map.of()).code()).isEqualTo("no-actor");
    }

    @Test
    void valueThatDoesNotExistRefusesTheWholeAction() {
        assertThat(refusal("cook", "pot", "hopeless", Map.of()))
                .hasMessageContaining("semantic.missing")
                .extracting(ActionRefused::code)
                .isEqualTo("no-value");
    }

    @Test
    void whatIsCreatedNeedsTheItemsThatItIsAbout() throws Exception {
        act("cook", "cup", "trash", Map.of("what", "tray"));

        var refused = refusal("cook", "cup", "serve", Map.of());
        assertThat(refused.code()).isEqualTo("cannot-create");
        assertThat(refused).hasMessageContaining("tray");
    }

    /** Another agent cannot prevent that an item is created by using its name first. */
    @Test
    void createdItemsHaveANameThatIsFree() throws Exception {
        long id = world.lastId() + 2;
        world.add(ItemDefinition.named("crumb-" + (id + 1)).build());
        world.add(ItemDefinition.named("crumb-" + (id + 1) + "-2").build());

        act("cook", "pot", "crumble", Map.of());

        assertThat(world.item(new ItemId(id + 1)).name()).isEqualTo("crumb-" + (id + 1) + "-3");
        assertThat(world.item(new ItemId(id + 2)).name()).isEqualTo("crumb-" + (id + 2));
    }

    @Test
    void forcesBeyondTheBudgetAreRefused() throws Exception {
        var budget = new ForceBudget();
        for (int i = 0; i < ForceBudget.OF_AGENT; i++) {
            blow(budget, "ann", 1);
        }
        var refused = catchThrowableOfType(ActionRefused.class, () -> blow(budget, "ann", 1));
        assertThat(refused.code()).isEqualTo("too-many-forces");
        assertThat(refused)
                .hasMessageContaining("1 force")
                .hasMessageContaining("1000 of at most 1000");
        assertThat(world.forces().active()).hasSize(ForceBudget.OF_AGENT);
        blow(budget, "bob", 1);
        blow(budget, "ann", 2); // forces last for one frame
    }

    private void blow(ForceBudget budget, String agent, long frame) throws ActionRefused {
        Action blow = item("pot").access().find("blow").orElseThrow();
        new ActionCall(
                        world,
                        frame,
                        item("pot"),
                        Optional.empty(),
                        Arguments.check(blow, Map.of("f", List.of(1, 2, 3))),
                        List.of(),
                        new ItemQuota(agent, 1, 1),
                        EventBudget.unlimited(),
                        budget,
                        new SymbolBudget(60))
                .perform(blow);
    }

    @Test
    void itemsAreTakenPutAndDropped() throws Exception {
        act("cook", "cup", "take", Map.of());
        assertThat(item("cup").parent()).contains(item("cook").id());
        item("cook").physical().setLocation(0, 0, 5);
        FrameControl.of(world).placeAttached();
        assertThat(item("cup").physical().location()).containsExactly(0, 3, 5);

        act("mouse", "cup", "put", Map.of("to", "tray"));
        assertThat(item("cup").parent()).contains(item("tray").id());
        assertThat(refusal("mouse", "cup", "trash", Map.of("what", "tray")).code())
                .isEqualTo("cannot-remove");
        assertThat(refusal("mouse", "cup", "put", Map.of("to", "world")).code())
                .isEqualTo("not-a-body");
        act("mouse", "cup", "drop", Map.of());
        assertThat(item("cup").parent()).isEmpty();

        assertThat(refusal("mouse", "cup", "drop", Map.of()).code()).isEqualTo("not-attached");
        assertThat(refusal("mouse", "cup", "put", Map.of("to", "cup")).code())
                .isEqualTo("cannot-attach");
        assertThat(refusal("mouse", "cup", "put", Map.of("to", "saucer")).code())
                .isEqualTo("no-such-item");
        act("mouse", "cup", "bin", Map.of());
        assertThat(world.find("cup")).isEmpty();
    }

    @Test
    void itemsAreCreatedUnderNamesOfTheirOwn() throws Exception {
        long last = world.lastId();

        act("cook", "pot", "crumble", Map.of());

        assertThat(world.find("pot")).isEmpty();
        Item crumb = item("crumb-" + (last + 1));
        assertThat(crumb.physical().location()).containsExactly(1, 1, 0);
        assertThat(crumb.physics().vector("velocity")).containsExactly(1, 0, 0);
        assertThat(crumb.physics().scalar("mass")).isEqualTo(0.001);
        assertThat(crumb.semantic().get("of")).contains("pot");
        assertThat(crumb.semantic().get("class")).contains("crumb");
        assertThat(crumb.physical().colour().toString()).isEqualTo("#112233ff");
        assertThat(item("crumb-" + (last + 2)).physical().location()).containsExactly(0, 0, 0);
    }

    @Test
    void forceLastsItsFramesAndLeavesTheColumnAsItWas() throws Exception {
        item("pot").physics().set("appliedForce", 0.1, 0, 0);
        var bus = new FrameBus();
        var loop = new FrameLoop(world, bus, new Timing(10, 1), Pacing.FAST);
        double[][] seen = new double[5][];
        bus.subscribe(
                FramePhase.PHYSICS,
                "physics",
                event -> seen[(int) event.frame()] = item("pot").physics().vector("appliedForce"));
        act("cook", "pot", "blow", Map.of("f", List.of(0.003, 0, 0)));
        act("cook", "pot", "kick", Map.of());
        for (int frame = 1; frame <= 4; frame++) {
            loop.step();
            assertThat(item("pot").physics().vector("appliedForce")).containsExactly(0.1, 0, 0);
        }
        assertThat(seen[1]).containsExactly(0.1 + 3, 0, 5);
        assertThat(seen[2]).containsExactly(0.1 + 3, 0, 0);
        assertThat(seen[3]).containsExactly(0.1 + 3, 0, 0); // 0.25 s are three frames of 0.1 s
        assertThat(seen[4]).containsExactly(0.1, 0, 0);
        assertThat(world.forces().active()).isEmpty();
    }

    @Test
    void actionInJavaDecidesAndTheWorldDoes() throws Exception {
        act("cook", "pot", "lift", Map.of("by", 2));
        assertThat(item("pot").physical().location()).containsExactly(1, 2, 0);
        assertThat(world.events().getLast().type()).isEqualTo("up");
        assertThat(refusal("cook", "pot", "lift", Map.of("by", 6)).code())
                .isEqualTo("out-of-range");
        item("pot").physics().set("mass", 11);
        assertThat(refusal("cook", "pot", "lift", Map.of("by", 1)).code())
                .isEqualTo("condition-failed");
    }

    @ParameterizedTest
    @ValueSource(
            strings = {
                "throw",
                "recurse",
                "symbol",
                "physics",
                "remove",
                "event",
                "numbers",
                "infinite",
                "unit",
                "twice",
                "property"
            })
    void actionInJavaThatBreaksIsRefusedAndHarmsNothing(String how) {
        ActionRefused refused = refusal("cook", "pot", "break", Map.of("how", how));

        assertThat(refused.code()).isIn("action-failed", "no-value", "no-such-property");
        assertThat(refused.getMessage()).isNotBlank();
    }

    @Test
    void actionsAreWrittenAsTheyWereRead() throws Exception {
        var writer = new ItemWriter(world.prototype());
        for (String name : List.of("pot", "cup", "cook")) {
            String text = writer.write(item(name).definition());
            assertThat(writer.write(WorldFile.parseItem("again", text, world.prototype())))
                    .isEqualTo(text);
        }
        assertThat(writer.write(item("pot").definition()))
                .contains("$physics.temperature + by", "java: test.levitate", "needs: [grip]")
                .contains("when: [physics.temperature + by < 400");
        assertThat(Optional.of(item("cook").access().capabilities()))
                .contains(List.of("grip", "push"));
    }
}
