// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import org.junit.jupiter.api.Test;

import java.util.List;
import java.util.Map;

class ClassHierarchyTest {
    private static final ItemClass VESSEL =
            new ItemClass(
                    "vessel",
                    "body",
                    "",
                    Map.of("holds", "liquid", "fragile", false),
                    Map.of("mass", List.of(2.0), "inertia", List.of(1.0, 2.0, 3.0)));
    private static final ItemClass CUP =
            new ItemClass(
                    "cup",
                    "vessel",
                    "",
                    Map.of("fragile", true),
                    Map.of("charge", List.of(0.5), "density", List.of(2600.0)));

    private static WorldPrototype prototype(ItemClass... classes) {
        return WorldPrototype.standard("si-f64").withClasses(List.of(classes));
    }

    private static ItemClass named(String name, String parent) {
        return new ItemClass(name, parent, "", Map.of(), Map.of());
    }

    @Test
    void aClassInheritsFromThoseAboveIt() {
        // declared in the other order
        ClassHierarchy classes = prototype(CUP, VESSEL).classes();
        assertThat(classes.lineage("cup")).containsExactly("cup", "vessel", "body");
        assertThat(classes.kind("cup")).contains("body");
        assertThat(classes.symbols("cup"))
                .containsExactly(Map.entry("fragile", true), Map.entry("holds", "liquid"));
        assertThat(classes.symbols("vessel")).containsEntry("fragile", false);
        assertThat(classes.isA("cup", "vessel")).isTrue();
        assertThat(classes.isA("cup", "body")).isTrue();
        assertThat(classes.isA("vessel", "cup")).isFalse();
    }

    @Test
    void aDensityReplacesTheMassOfTheClassAbove() {
        assertThat(prototype(VESSEL, CUP).classes().properties("cup"))
                .isEqualTo(Map.of("charge", List.of(0.5), "density", List.of(2600.0)));
    }

    @Test
    void anUndeclaredClassHasNothingAboveIt() {
        ClassHierarchy classes = prototype(VESSEL).classes();
        assertThat(classes.lineage("toy")).containsExactly("toy");
        assertThat(classes.isA("toy", "toy")).isTrue();
        assertThat(classes.isA("toy", "body")).isFalse();
        assertThat(classes.symbols("toy")).isEmpty();
    }

    @Test
    void hierarchiesWithoutATopAreRefused() {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> prototype(named("a", "b"), named("b", "a")))
                .withMessage("class a: classes are above themselves: a, b, a");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> prototype(named("a", "b")))
                .withMessage("class a is a b, which does not exist");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> prototype(named("a", "body"), named("a", "body")))
                .withMessage("class a is declared twice");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> prototype(named("spring", "body")))
                .withMessage("class spring has the name of a kind, expected another name");
    }

    @Test
    void inheritedSymbolsFollowTheClassOfTheItem() {
        World world = new World("test", prototype(VESSEL, CUP), new OffHeapArena());
        Item mug = world.add(ItemDefinition.named("mug").symbol("class", "cup").build());
        assertThat(mug.semantic().get("fragile")).contains(true);
        assertThat(mug.semantic().get("classes")).contains(List.of("cup", "vessel", "body"));
        assertThat(mug.semantic().symbols())
                .containsExactly(
                        Map.entry("name", "mug"),
                        Map.entry("class", "cup"),
                        Map.entry("classes", List.of("cup", "vessel", "body")),
                        Map.entry("fragile", true),
                        Map.entry("holds", "liquid"));

        mug.semantic().derive("fragile", false);
        assertThat(mug.semantic().get("fragile")).contains(false);
        mug.semantic().set("fragile", true);
        assertThat(mug.semantic().get("fragile")).contains(true);
        mug.semantic().remove("fragile");
        mug.semantic().derive("fragile", null);

        mug.semantic().set("class", "vessel");
        assertThat(mug.semantic().get("fragile")).contains(false);
        assertThat(mug.semantic().isA("cup")).isFalse();
        mug.semantic().set("class", "shard");
        assertThat(mug.semantic().get("holds")).isEmpty();
        assertThat(mug.semantic().get("classes")).contains(List.of("shard"));
        assertThat(mug.semantic().symbols()).containsOnlyKeys("name", "class");
        // definitions contain only own symbols
        assertThat(mug.definition().symbols()).isEqualTo(Map.of("class", "shard"));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> mug.semantic().set("classes", List.of("x")))
                .withMessageContaining("classes is a symbol that the world derives");
    }

    @Test
    void theIndexFindsTheItemsOfAllClassesBelow() {
        World world = new World("test", prototype(VESSEL, CUP), new OffHeapArena());
        Item mug = world.add(ItemDefinition.named("mug").symbol("class", "cup").build());
        Item pot = world.add(ItemDefinition.named("pot").symbol("class", "vessel").build());
        Item stone = world.add(ItemDefinition.named("stone").build());
        assertThat(world.withSymbol("classes", "vessel")).containsExactly(mug, pot);
        assertThat(world.withSymbol("classes", "body")).containsExactly(mug, pot, stone);
        assertThat(world.withSymbol("class", "vessel")).containsExactly(pot);
        assertThat(world.withSymbol("fragile", true)).containsExactly(mug);
        stone.semantic().set("class", "cup");
        mug.semantic().set("class", "shard");
        assertThat(world.withSymbol("classes", "vessel")).containsExactly(pot, stone);
        assertThat(world.withSymbol("fragile", true)).containsExactly(stone);
        world.remove(stone.id());
        assertThat(world.withSymbol("classes", "cup")).isEmpty();
    }

    @Test
    void aWorldWithoutClassesHasNoSymbolOfThisName() {
        World world = new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena());
        Item mug = world.add(ItemDefinition.named("mug").symbol("class", "cup").build());
        assertThat(mug.semantic().get("classes")).isEmpty();
        assertThat(mug.semantic().isA("cup")).isTrue();
        assertThat(mug.semantic().isA("body")).isFalse();
        mug.semantic().set("classes", List.of("first", "second"));
        assertThat(mug.semantic().get("classes")).contains(List.of("first", "second"));
    }
}
