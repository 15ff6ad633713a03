// SPDX-License-Identifier: Apache-2.0
package reve.core.image;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.mesh.Assets;
import reve.core.mesh.WorldFolder;
import reve.core.unit.Unit;
import reve.core.world.Colour;
import reve.core.world.Column;
import reve.core.world.ConnectionLook;
import reve.core.world.Force;
import reve.core.world.FrameControl;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.Shape;
import reve.core.world.SnapshotRing;
import reve.core.world.SymbolDescriptor;
import reve.core.world.SymbolType;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldChange;
import reve.core.world.WorldEvent;
import reve.core.world.WorldImage;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.lang.foreign.ValueLayout;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.HexFormat;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;

/** Images and changes describe the same world after they are encoded and decoded. */
class WorldCodecTest {

    private static final WorldPrototype PROTOTYPE =
            WorldPrototype.standard("si-f64")
                    .extendedBy(
                            List.of(
                                    new PropertyDescriptor(
                                            "temperature",
                                            "body",
                                            ScalarType.F32,
                                            1,
                                            Unit.parse("K"),
                                            Optional.empty(),
                                            0,
                                            "How hot it is."),
                                    new PropertyDescriptor(
                                            "owner",
                                            "deed",
                                            ScalarType.REF,
                                            2,
                                            Unit.ONE,
                                            Optional.of("body"),
                                            "Who has it.")))
                    .withSymbols(
                            List.of(
                                    new SymbolDescriptor(
                                            "reach",
                                            SymbolType.NUMBER,
                                            Unit.parse("km"),
                                            "How far.")));

    private static final Assets NONE = new Assets(WorldFolder.none());

    @ParameterizedTest(name = "seed {0}")
    @ValueSource(longs = {1, 2, 3, 4, 5, 6})
    void anImageComesBackToTheBit(long seed) {
        World world = empty();
        change(world, new Random(seed), 200);
        Item last = world.items().getLast();
        last.semantic().derive("warm", true);
        last.semantic().derive("tags", List.of("a", 2.0));
        world.forces().add(new Force(last.id(), List.of(1.0, -0.0, 1e-300), seed));
        World other = empty();
        try (WorldImage image = new WorldImage(world);
                WorldImage back = new WorldImage(other)) {
            image.copyFrom(world, 12);
            byte[] bytes = Sections.write(new WorldImageCodec(PROTOTYPE, NONE).write(image));
            new WorldImageCodec(PROTOTYPE, NONE).read(Sections.read(bytes), back);
            other.restore(back);
            assertThat(back.frame()).isEqualTo(12);
            assertThat(everything(other)).isEqualTo(everything(world));
            assertThat(other.items().stream().map(Item::children).toList().toString())
                    .isEqualTo(world.items().stream().map(Item::children).toList().toString());
        }
    }

    @ParameterizedTest(name = "seed {0}")
    @ValueSource(longs = {1, 2, 3, 4, 5, 6})
    void framesKeepACopyEqualToTheBit(long seed) {
        Random random = new Random(seed);
        World world = empty();
        World copy = empty();
        SnapshotRing ring = new SnapshotRing(world, 3);
        var encoder = new FrameEncoder(PROTOTYPE, NONE);
        var decoder = new FrameDecoder(PROTOTYPE, NONE);
        List<WorldEvent> events =
                List.of(new WorldEvent(7, "rang", Map.of("times", 3L, "at", 0.5, "who", "ä")));
        try (WorldImage image = new WorldImage(copy)) {
            for (int frame = 1; frame <= 40; frame++) {
                change(world, random, random.nextInt(8));
                editDirectly(world, random);
                if (world.itemCount() > 1) {
                    world.items().getLast().semantic().derive("frame", (double) frame);
                }
                ring.publish(frame, frame / 60.0);
                if (random.nextInt(3) == 0) {
                    continue; // a slow reader misses frames
                }
                byte[] bytes;
                try (WorldSnapshot snapshot = ring.acquireLatest().orElseThrow()) {
                    bytes = encoder.write(snapshot, events).orElseThrow();
                }
                FrameDecoder.Frame read = decoder.read(bytes, image);
                assertThat(read).isEqualTo(new FrameDecoder.Frame(frame, frame / 60.0, events));
                copy.restore(image);
                assertThat(everything(copy)).isEqualTo(everything(world));
            }
        }
    }

    @Test
    void aFrameWithoutChangesIsShort() {
        World world = empty();
        for (int i = 0; i < 1000; i++) {
            world.add(ItemDefinition.named("body " + i).at(i, 0, 0).build());
        }
        SnapshotRing ring = new SnapshotRing(world, 3);
        var encoder = new FrameEncoder(PROTOTYPE, NONE);
        ring.publish(1, 0);
        try (WorldSnapshot whole = ring.acquireLatest().orElseThrow()) {
            assertThat(encoder.write(whole, List.of()).orElseThrow()).hasSizeGreaterThan(50_000);
        }
        world.items().getLast().physical().setLocation(1, 2, 3);
        ring.publish(2, 0);
        try (WorldSnapshot changed = ring.acquireLatest().orElseThrow()) {
            assertThat(encoder.write(changed, List.of()).orElseThrow()).hasSizeLessThan(500);
        }
    }

    @Test
    void aFrameThatDoesNotFitIsRefused() {
        World world = empty();
        world.add(ItemDefinition.named("body").build());
        SnapshotRing ring = new SnapshotRing(world, 3);
        var encoder = new FrameEncoder(PROTOTYPE, NONE);
        ring.publish(1, 0);
        byte[] first = write(encoder, ring);
        world.items().getLast().semantic().set("mood", "glad");
        ring.publish(2, 0);
        byte[] second = write(encoder, ring);
        try (WorldImage image = new WorldImage(empty())) {
            assertThatExceptionOfType(CorruptException.class)
                    .isThrownBy(() -> new FrameDecoder(PROTOTYPE, NONE).read(second, image))
                    .withMessageContaining("which does not exist");
            first[first.length / 2]++;
            assertThatExceptionOfType(CorruptException.class)
                    .isThrownBy(() -> new FrameDecoder(PROTOTYPE, NONE).read(first, image))
                    .withMessageContaining("checksum");
        }
    }

    private static byte[] write(FrameEncoder encoder, SnapshotRing ring) {
        try (WorldSnapshot snapshot = ring.acquireLatest().orElseThrow()) {
            return encoder.write(snapshot, List.of()).orElseThrow();
        }
    }

    @Test
    void anImageThatNamesNoMakersIsRead() {
        World world = empty();
        world.add(ItemDefinition.named("old").build());
        World other = empty();
        try (WorldImage image = new WorldImage(world);
                WorldImage back = new WorldImage(other)) {
            image.copyFrom(world, 1);
            Map<String, byte[]> sections =
                    new LinkedHashMap<>(new WorldImageCodec(PROTOTYPE, NONE).write(image));
            String items = new String(sections.get("items"), StandardCharsets.UTF_8);
            assertThat(items).contains("\"made\":{}");
            sections.put(
                    "items",
                    items.replace("\"made\":{}", "\"none\":{}").getBytes(StandardCharsets.UTF_8));
            new WorldImageCodec(PROTOTYPE, NONE).read(sections, back);
            other.restore(back);
            assertThat(everything(other)).isEqualTo(everything(world));
        }
    }

    /** Columns of zeros have no section. Therefore only the number of items bounds their length. */
    @Test
    void anImageThatClaimsMoreRowsThanItemsTakesNoMemory() {
        World world = empty();
        world.add(ItemDefinition.named("only").build());
        try (WorldImage image = new WorldImage(world);
                WorldImage back = new WorldImage(empty())) {
            image.copyFrom(world, 1);
            Map<String, byte[]> sections =
                    new LinkedHashMap<>(new WorldImageCodec(PROTOTYPE, NONE).write(image));
            String tables = new String(sections.get("world"), StandardCharsets.UTF_8);
            for (String rows : List.of("2147483647", "-1", "4294967297", "null")) {
                sections.put(
                        "world",
                        tables.replaceFirst("\"rows\":[0-9]+", "\"rows\":" + rows)
                                .getBytes(StandardCharsets.UTF_8));
                assertThatExceptionOfType(CorruptException.class)
                        .isThrownBy(() -> new WorldImageCodec(PROTOTYPE, NONE).read(sections, back))
                        .withMessageContaining("the field rows: found " + rows + ", expected");
            }
        }
    }

    @ParameterizedTest(name = "seed {0}")
    @ValueSource(longs = {11, 12, 13, 14, 15, 16})
    void changesMadeAgainMakeTheSameWorld(long seed) {
        World world = empty();
        World other = empty();
        FrameControl.of(world).end();
        Random random = new Random(seed);
        var writer = new ChangeCodec(PROTOTYPE, NONE);
        var reader = new ChangeCodec(PROTOTYPE, NONE);
        for (int frame = 0; frame < 30; frame++) {
            change(world, random, 10);
            editDirectly(world, random);
            List<byte[]> journal = new ArrayList<>();
            for (WorldChange change : world.changes()) {
                journal.add(Trees.write(writer.write(change, rows(world, change))));
            }
            FrameControl.of(world).end();
            journal.forEach(change -> reader.apply(other, Trees.read(change)));
            FrameControl.of(world).placeAttached();
            FrameControl.of(other).placeAttached();
            assertThat(everything(other)).as("frame %d", frame).isEqualTo(everything(world));
        }
    }

    @Test
    void aChangeThatCannotBeMadeIsToldWithTheReason() {
        var codec = new ChangeCodec(PROTOTYPE, NONE);
        assertThatExceptionOfType(CorruptException.class)
                .isThrownBy(() -> codec.apply(empty(), Trees.read("{\"detach\": 99}".getBytes())))
                .withMessageContaining("{\"detach\":99}")
                .withMessageContaining("no item #99");
        assertThatExceptionOfType(CorruptException.class)
                .isThrownBy(() -> codec.apply(empty(), Trees.read("{}".getBytes())))
                .withMessageContaining("kind is missing");
    }

    @Test
    void anImageOfAnotherPrototypeIsRefused() {
        World narrow = new World("test", WorldPrototype.standard("si-f32"), new OffHeapArena());
        World wide = empty();
        try (WorldImage from = new WorldImage(narrow);
                WorldImage into = new WorldImage(wide)) {
            from.copyFrom(narrow, 0);
            var sections = new WorldImageCodec(narrow.prototype(), NONE).write(from);
            assertThatExceptionOfType(CorruptException.class)
                    .isThrownBy(() -> new WorldImageCodec(PROTOTYPE, NONE).read(sections, into))
                    .withMessageContaining("kinds");
        }
    }

    @Test
    void prototypesComeBackWithWhatDesignersAdded() {
        WorldPrototype back =
                PrototypeCodec.read(Trees.read(Trees.write(PrototypeCodec.write(PROTOTYPE))));
        assertThat(back.name()).isEqualTo(PROTOTYPE.name());
        assertThat(back.properties()).isEqualTo(PROTOTYPE.properties());
        assertThat(back.symbols()).isEqualTo(PROTOTYPE.symbols());
        assertThat(back.kinds()).isEqualTo(PROTOTYPE.kinds());
    }

    private static World empty() {
        return new World("test", PROTOTYPE, new OffHeapArena());
    }

    private static byte[] rows(World world, WorldChange change) {
        return change instanceof WorldChange.ColumnEdited edited
                ? world.table(edited.kind())
                        .column(edited.property())
                        .segment()
                        .toArray(ValueLayout.JAVA_BYTE)
                : null;
    }

    /**
     * Makes the last changes of a frame. Therefore the rows still have the written values at its
     * end.
     */
    private static void editDirectly(World world, Random random) {
        if (random.nextInt(4) == 0 && world.table("body").rowCount() > 0) {
            Column column = world.table("body").column("temperature");
            column.setDouble(random.nextInt(column.rowCount()), 0, random.nextFloat());
        }
    }

    private static void change(World world, Random random, int times) {
        for (int i = 0; i < times; i++) {
            List<Item> bodies =
                    world.items().stream().filter(item -> item.kind().equals("body")).toList();
            if (bodies.size() < 4 || random.nextInt(4) == 0) {
                String maker = random.nextInt(3) == 0 ? null : "agent-" + random.nextInt(3);
                world.addAll(List.of(body(random)), maker);
                continue;
            }
            Item any = bodies.get(random.nextInt(bodies.size()));
            Item other = bodies.get(random.nextInt(bodies.size()));
            switch (random.nextInt(13)) {
                case 0 -> world.removeCascade(any.id());
                case 1 -> world.rename(any.id(), "renamed " + random.nextLong());
                case 2 -> attach(world, other, any);
                case 3 -> {
                    if (any.parent().isPresent()) {
                        world.detach(any.id());
                    }
                }
                case 4 -> any.physical().setLocation(random.nextGaussian(), -0.0, 1e-300);
                case 5 -> any.physical().setOrientation(random.nextGaussian(), 1, 0, 0);
                case 6 ->
                        any.physical()
                                .setShape(
                                        random.nextBoolean()
                                                ? Shape.none()
                                                : Shape.box(1, random.nextDouble() + 0.1, 3));
                case 7 -> any.physical().setColour(new Colour(random.nextInt()));
                case 8 ->
                        any.semantic()
                                .set(
                                        "mood " + random.nextInt(3),
                                        random.nextBoolean()
                                                ? (Object) random.nextDouble()
                                                : "söso \"");
                case 9 -> any.semantic().remove("mood 1");
                case 10 -> any.physics().set("temperature", random.nextFloat());
                case 11 -> clearPhysics(world, any);
                default -> addSpring(world, random, any, other);
            }
        }
    }

    private static ItemDefinition body(Random random) {
        var item =
                ItemDefinition.named("item " + random.nextLong())
                        .at(random.nextGaussian(), random.nextGaussian(), 0)
                        .symbol("class", "thing")
                        .symbol("heavy", random.nextBoolean());
        return random.nextBoolean()
                ? item.build()
                : item.physics("velocity", random.nextGaussian(), -0.0, 1).build();
    }

    private static void attach(World world, Item child, Item parent) {
        if (child.id().compareTo(parent.id()) > 0 && child.physics().isEmpty()) {
            world.attach(child.id(), parent.id());
        }
    }

    private static void clearPhysics(World world, Item item) {
        try {
            item.physics().clear();
        } catch (IllegalArgumentException referredTo) {
            world.removeCascade(item.id());
        }
    }

    private static void addSpring(World world, Random random, Item one, Item other) {
        if (!one.physics().isEmpty() && !other.physics().isEmpty()) {
            Item spring =
                    world.add(
                            ItemDefinition.named("spring " + random.nextLong())
                                    .kind("spring")
                                    .look(ConnectionLook.DEFAULT.with(random.nextInt(2)))
                                    .physics("length", random.nextDouble())
                                    .reference("end1", one.name())
                                    .reference("end2", other.name())
                                    .build());
            spring.physics().setReferences("end1", other.id());
            if (random.nextBoolean()) {
                spring.physical().setColour(new Colour(random.nextInt()));
                spring.physical().setWidth(random.nextDouble());
            }
        }
    }

    private static Map<String, Object> everything(World world) {
        Map<String, Object> all = new LinkedHashMap<>();
        all.put("symbols", Map.copyOf(world.symbols()));
        all.put("forces", world.forces().active());
        all.put("made", List.of(world.made(), world.made("agent-0"), world.made("agent-2")));
        all.put("items", world.items().stream().map(Item::toString).toList());
        for (Table table : world.tables()) {
            all.put(table.kind(), table.physicsRowCount());
            for (int row = 0; row < table.rowCount(); row++) {
                all.put(table.kind() + " row " + row, table.idAt(row));
            }
            table.columns()
                    .forEach(
                            column ->
                                    all.put(
                                            table.kind() + "." + column.name(),
                                            HexFormat.of()
                                                    .formatHex(
                                                            column.segment()
                                                                    .toArray(
                                                                            ValueLayout
                                                                                    .JAVA_BYTE))));
        }
        return all;
    }
}
