// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.Seed;
import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.file.AgentPolicy;
import reve.core.world.ActionRefused;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.Parameter;
import reve.core.world.Sensor;
import reve.core.world.Sensor.Aspect;
import reve.core.world.Shape;
import reve.core.world.TestAction;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.EnumSet;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.Set;
import java.util.TreeSet;
import java.util.stream.IntStream;

/** Data that no sensor of a body reaches is never sent, and the agent cannot act on its item. */
class SensorsTest {

    private static final double QUARTER_TURN = Math.sqrt(0.5);

    @Test
    void aRangeIsMeasuredToTheNearestPointOfTheBox() throws IOException {
        assertThat(
                        sensed(
                                Sensor.sight("eyes", 5),
                                box("near", 7, 0, 0, 4),
                                box("far", 7.1, 0, 0, 4)))
                .containsExactly("ada", "near");
    }

    @Test
    void theFieldOfViewIsAroundTheBodysOwnZ() throws IOException {
        Sensor eyes = Sensor.sight("eyes", 100).withFieldOfView(Math.PI / 2);
        ItemDefinition[] around = {
            ball("ahead", 0, 0, 9),
            ball("left", 9, 0, 0),
            ball("behind", 0, 0, -9),
            ball("edge", 8.9, 0, 9)
        };
        assertThat(sensed(eyes, around)).containsExactly("ada", "ahead", "edge");
        assertThat(sensed(body(eyes).orientation(0, QUARTER_TURN, 0, QUARTER_TURN).build(), around))
                .containsExactly("ada", "left", "edge");
    }

    @Test
    void aBoxHidesWhatIsWhollyBehindIt() throws IOException {
        Sensor eyes = Sensor.sight("eyes", 100).withLineOfSight();
        assertThat(
                        sensed(
                                eyes,
                                box("wall", 0, 0, 5, 2),
                                ball("hidden", 0, 0, 9),
                                ball("beside", 9, 0, 9),
                                box("peeking", 0, 0, 12, 8)))
                .containsExactly("ada", "wall", "beside", "peeking");
    }

    @Test
    void aBoxThatHoldsTheEyeHidesNothingAndAPointHidesNothing() throws IOException {
        Sensor eyes = Sensor.sight("eyes", 100).withLineOfSight();
        assertThat(
                        sensed(
                                eyes,
                                box("room", 0, 0, 0, 30),
                                place("mark", 0, 0, 4),
                                ball("ball", 0, 0, 9)))
                .containsExactly("ada", "room", "mark", "ball");
    }

    @Test
    void touchSensesWhatTheBodysBoxComesCloseTo() throws IOException {
        assertThat(
                        sensed(
                                Sensor.touch("skin"),
                                box("touching", 1.5, 0, 0, 2),
                                box("apart", -1.6, 0, 0, 2)))
                .containsExactly("ada", "touching");
    }

    @Test
    void onlyTheSymbolsAndAspectsOfTheSensorAreSent() throws IOException {
        Sensor eyes =
                Sensor.sight("eyes", 100)
                        .withSymbols(Set.of("class", "smell"))
                        .withAspects(EnumSet.of(Aspect.SEMANTIC));
        try (AgentRoom room = room(body(eyes).build(), AgentRoom.duck());
                TestClient ada = room.join("ada")) {
            JsonNode duck = perceive(room, ada).get("items").get(0);
            assertThat(duck)
                    .isEqualTo(TestClient.json("{'name':'duck','symbols':{'class':'toy'}}"));
        }
    }

    @Test
    void severalSensorsShowTogetherWhatEachShows() throws IOException {
        Sensor far = Sensor.sight("far", 100).withAspects(EnumSet.of(Aspect.PHYSICAL));
        Sensor near =
                Sensor.sight("near", 5)
                        .withSymbols(Set.of("class"))
                        .withAspects(EnumSet.of(Aspect.SEMANTIC, Aspect.ACCESS));
        ItemDefinition body = body(far).sensor(near).build();
        try (AgentRoom room = room(body, ball("close", 2, 0, 0), ball("away", 50, 0, 0));
                TestClient ada = room.join("ada")) {
            JsonNode items = perceive(room, ada).get("items");
            assertThat(items.get(0))
                    .isEqualTo(
                            TestClient.json(
                                    "{'name':'close','location':[2.0,0.0,0.0],"
                                            + "'symbols':{'class':'body'},'actions':{}}"));
            assertThat(items.get(1))
                    .isEqualTo(TestClient.json("{'name':'away','location':[50.0,0.0,0.0]}"));
        }
    }

    @Test
    void aSlowSensorKeepsWhatItSensedUntilItIsItsTurn() throws IOException {
        try (AgentRoom room =
                        room(
                                body(Sensor.sight("eyes", 100).withEvery(3)).build(),
                                ball("ball", 1, 0, 0));
                TestClient ada = room.join("ada")) {
            var seen = new ArrayList<Double>();
            for (int i = 0; i < 7; i++) {
                room.item("ball").physical().setLocation(i, 0, 0);
                seen.add(perceive(room, ada).at("/items/0/location/0").doubleValue());
            }
            assertThat(seen).containsExactly(0.0, 0.0, 0.0, 3.0, 3.0, 3.0, 6.0);
        }
    }

    @Test
    void anEventAboutWhatIsNotSensedIsNotHeardAndUnsensedNamesAreLeftOut() throws IOException {
        ItemDefinition bell =
                ItemDefinition.named("bell")
                        .shape(Shape.sphere(1))
                        .at(0, 0, 3)
                        .action(
                                new DeclaredAction(
                                        "ring",
                                        "Rings.",
                                        List.of(),
                                        List.of(new Effect.Raise("rang", "ring"))))
                        .build();
        var policy = new AgentPolicy(List.of("mole", "owl"), Optional.empty());
        ItemDefinition mole = body("mole", Sensor.sight("nose", 5)).build();
        ItemDefinition owl = body("owl", Sensor.sight("eyes", 500)).at(0, 90, 0).build();
        ItemDefinition gong =
                ItemDefinition.named("gong")
                        .shape(Shape.sphere(1))
                        .at(0, 95, 0)
                        .action(bell.actions().getFirst())
                        .build();
        try (AgentRoom room =
                        new AgentRoom(
                                AgentRoom.CONFIG, policy, 64, List.of(mole, owl, bell, gong));
                TestClient ada = room.connect();
                TestClient bob = room.connect()) {
            ada.say("{'t':'hello','protocol':1,'name':'ada','body':'mole'}").sync();
            bob.say("{'t':'hello','protocol':1,'name':'bob','body':'owl'}").sync();
            room.step();
            ada.expect("welcome");
            assertThat(ada.expect("event").get("fields"))
                    .isEqualTo(TestClient.json("{'agent':'ada','body':'mole'}"));
            bob.say("{'t':'act','id':1,'item':'gong','action':'ring'}").sync();
            room.step();
            bob.say("{'t':'act','id':2,'item':'bell','action':'ring'}").sync();
            room.step();
            assertThat(ada.expect("event").get("fields"))
                    .isEqualTo(TestClient.json("{'item':'bell','action':'ring'}"));
            assertThat(ada.expect("event").get("fields"))
                    .isEqualTo(TestClient.json("{'item':'bell','action':'ring'}"));
            ada.say("{'t':'ping','id':1}").expect("pong");
        }
    }

    @Test
    void whatIsNotSensedCannotBeActedOnAndTheRefusalDoesNotTellThatItIsThere() throws IOException {
        try (AgentRoom room = room(body(Sensor.sight("eyes", 2)).build(), AgentRoom.duck());
                TestClient ada = room.join("ada")) {
            String act = "{'t':'act','id':%d,'item':'%s','action':'wind-up'}";
            ada.say(act.formatted(1, "duck")).say(act.formatted(2, "swan")).sync();
            room.step();
            String duck = ada.expect("result", "no-such-item").get("reason").stringValue();
            String swan = ada.expect("result", "no-such-item").get("reason").stringValue();
            assertThat(swan).isEqualTo(duck.replace("duck", "swan"));
            room.item("duck").physical().setLocation(1, 0, 0);
            room.step();
            ada.say(act.formatted(3, "duck")).sync();
            room.step();
            assertThat(ada.expect("result").get("accepted").booleanValue()).isTrue();
        }
    }

    @ParameterizedTest
    @ValueSource(
            strings = {
                "condition-failed",
                "no-value",
                "out-of-range",
                "not-a-rotation",
                "not-a-colour",
                "not-a-symbol"
            })
    void whoSensesOnlySomeThingsIsNotToldWhatAnActionFound(String code) throws IOException {
        var open =
                new TestAction(
                        "open",
                        "Opens.",
                        call -> {
                            throw new ActionRefused(code, "its number is 4711");
                        });
        ItemDefinition safe = ItemDefinition.named("safe").at(1, 0, 0).action(open).build();
        try (AgentRoom room = room(body(Sensor.sight("eyes", 2)).build(), safe);
                TestClient ada = room.join("ada")) {
            ada.say("{'t':'act','id':1,'item':'safe','action':'open'}").sync();
            room.step();
            assertThat(ada.expect("result", code).get("reason").stringValue())
                    .contains("safe")
                    .doesNotContain("4711");
        }
    }

    @Test
    void anItemThatIsNotSensedCannotBeNamedInAnArgument() throws IOException {
        Parameter guest = Parameter.item("whom", "Whom to greet.");
        ItemDefinition hand =
                ItemDefinition.named("hand")
                        .at(1, 0, 0)
                        .action(
                                new DeclaredAction(
                                        "greet",
                                        "Waves.",
                                        List.of(guest),
                                        List.of(new Effect.Raise("greeted", "greet"))))
                        .build();
        try (AgentRoom room = room(body(Sensor.sight("eyes", 2)).build(), hand, AgentRoom.duck());
                TestClient ada = room.join("ada")) {
            String act =
                    "{'t':'act','id':%d,'item':'hand','action':'greet','arguments':{'whom':'%s'}}";
            ada.say(act.formatted(1, "duck"))
                    .say(act.formatted(2, "swan"))
                    .say(act.formatted(3, "hand"))
                    .sync();
            room.step();
            String duck = ada.expect("result", "no-such-item").get("reason").stringValue();
            String swan = ada.expect("result", "no-such-item").get("reason").stringValue();
            assertThat(swan).isEqualTo(duck.replace("duck", "swan"));
            assertThat(ada.expect("result").get("accepted").booleanValue()).isTrue();
        }
    }

    /**
     * The data that a sensor senses now does not reveal data that another sensor has not sensed
     * yet.
     */
    @ParameterizedTest
    @CsvSource({"1, 3", "3, 1", "3, 2"})
    void whatASlowSensorShowsIsAsItSensedItThoughAnotherIsFaster(int placesEvery, int symbolsEvery)
            throws IOException {
        ItemDefinition body =
                body(Sensor.sight("where", 50)
                                .withAspects(EnumSet.of(Sensor.Aspect.PHYSICAL))
                                .withEvery(placesEvery))
                        .sensor(
                                Sensor.sight("what", 50)
                                        .withAspects(EnumSet.of(Sensor.Aspect.SEMANTIC))
                                        .withEvery(symbolsEvery))
                        .build();
        try (AgentRoom room = room(body, ball("ball", 3, 0, 0));
                TestClient ada = room.join("ada")) {
            ada.say("{'t':'perceive','id':1,'every':1}").sync();
            Map<String, JsonNode> known = new LinkedHashMap<>();
            int frames = 12;
            int[] places = new int[frames];
            int[] symbols = new int[frames];
            for (int frame = 0; frame < frames; frame++) {
                room.item("ball").physical().setLocation(frame, 0, 0);
                room.item("ball").semantic().set("mood", String.valueOf(frame));
                room.step();
                apply(ada.expect("perception"), known);
                places[frame] = known.get("ball").at("/location/0").intValue();
                symbols[frame] =
                        Integer.parseInt(known.get("ball").at("/symbols/mood").asString("-1"));
            }
            assertThat(isSensedEvery(placesEvery, places))
                    .as("%s", Arrays.toString(places))
                    .isTrue();
            assertThat(isSensedEvery(symbolsEvery, symbols))
                    .as("%s", Arrays.toString(symbols))
                    .isTrue();
        }
    }

    @Test
    void relationsAreAsOfWhenTheyWereSensed() throws IOException {
        try (AgentRoom room =
                        room(
                                body(Sensor.sight("slow", 50).withEvery(3)).build(),
                                ball("ball", 3, 0, 0),
                                ball("other", 4, 0, 0));
                TestClient ada = room.join("ada")) {
            ada.say("{'t':'perceive','id':1,'every':1,'relations':true}").sync();
            Map<String, JsonNode> known = new LinkedHashMap<>();
            boolean[] touching = new boolean[12];
            for (int frame = 0; frame < touching.length; frame++) {
                room.item("other").physical().setLocation(isApart(frame) ? 20 : 4, 0, 0);
                room.step();
                apply(ada.expect("perception"), known);
                touching[frame] = known.get("ball").at("/symbols/touching").size() > 0;
            }
            assertThat(IntStream.range(0, 3))
                    .as("%s", Arrays.toString(touching))
                    .anyMatch(
                            turn ->
                                    IntStream.range(turn, touching.length)
                                            .allMatch(
                                                    frame ->
                                                            touching[frame]
                                                                    != isApart(
                                                                            frame
                                                                                    - (frame - turn)
                                                                                            % 3)));
        }
    }

    private static boolean isApart(int frame) {
        return frame / 2 % 2 == 0;
    }

    /** Asserts that the known data in each frame is that of the sensor's last turn. */
    private static boolean isSensedEvery(int every, int[] known) {
        return IntStream.range(0, every)
                .anyMatch(
                        turn ->
                                IntStream.range(turn, known.length)
                                        .allMatch(
                                                frame ->
                                                        known[frame]
                                                                == frame - (frame - turn) % every));
    }

    @Test
    void inRandomWorldsExactlyWhatTheOracleSensesIsSentAndDifferencesAddUp() throws IOException {
        long seed = Seed.of("worlds");
        var random = new Random(seed);
        int sensed = 0;
        int hidden = 0;
        for (int world = 0; world < 60; world++) {
            ItemDefinition.Builder body = body(randomSensor(random, "a"));
            if (random.nextBoolean()) {
                body.sensor(randomSensor(random, "b"));
            }
            turn(random, body);
            ItemDefinition made = body.build();
            try (AgentRoom room = room(made);
                    TestClient ada = room.join("ada")) {
                int items = random.nextInt(20);
                for (int i = 0; i < items; i++) {
                    room.world.add(randomItem(random, "item-" + i + "-"));
                }
                ada.say("{'t':'perceive','id':1,'every':1}").sync();
                Map<String, JsonNode> known = new LinkedHashMap<>();
                for (int frame = 0; frame < 6; frame++) {
                    change(random, room, frame);
                    room.step();
                    JsonNode update = ada.next();
                    for (;
                            !update.get("t").stringValue().equals("perception");
                            update = ada.next()) {
                        assertThat(update.get("t").stringValue()).isEqualTo("event");
                    }
                    apply(update, known);
                    JsonNode whole = perceiveSame(room, ada, update);
                    Set<String> expected = oracle(room, made.sensors());
                    assertThat(known.keySet())
                            .as("seed %d world %d frame %d", seed, world, frame)
                            .isEqualTo(expected);
                    room.world.items().stream()
                            .map(Item::name)
                            .filter(name -> !expected.contains(name))
                            .forEach(
                                    name ->
                                            assertThat(whole.toString())
                                                    .doesNotContain("\"" + name + "\""));
                    assertThat(Set.copyOf(known.values()))
                            .as("seed %d world %d frame %d", seed, world, frame)
                            .isEqualTo(Set.copyOf(whole.get("items").valueStream().toList()));
                    sensed += expected.size() - 1;
                    hidden += room.world.items().size() - 1 - expected.size();
                }
            }
        }
        assertThat(sensed).isGreaterThan(200);
        assertThat(hidden).isGreaterThan(200);
    }

    /**
     * Returns the complete data of a frame in a world that does not change. The next frame is equal
     * except for its number.
     */
    private static JsonNode perceiveSame(AgentRoom room, TestClient ada, JsonNode update)
            throws IOException {
        ada.say("{'t':'perceive','id':2}").sync();
        room.step();
        JsonNode message = ada.expect("perception");
        JsonNode other = ada.expect("perception");
        boolean first = message.get("id").intValue() == 2;
        JsonNode difference = first ? other : message;
        assertThat(difference.get("since").longValue()).isEqualTo(update.get("frame").longValue());
        assertThat(difference.has("entered") || difference.has("left") || difference.has("changed"))
                .as("%s", difference)
                .isFalse();
        return first ? message : other;
    }

    private static void apply(JsonNode update, Map<String, JsonNode> known) {
        if (update.has("items")) {
            known.clear();
            update.get("items").forEach(item -> known.put(item.get("name").stringValue(), item));
        }
        update.path("left")
                .forEach(name -> assertThat(known.remove(name.stringValue())).isNotNull());
        update.path("entered")
                .forEach(
                        item ->
                                assertThat(known.put(item.get("name").stringValue(), item))
                                        .isNull());
        update.path("changed")
                .forEach(
                        change -> {
                            var item =
                                    known.get(change.get("name").stringValue())
                                            .asObject()
                                            .deepCopy();
                            item.setAll(change.asObject());
                            if (item.path("orientation")
                                    .equals(TestClient.json("[0.0,0.0,0.0,1.0]"))) {
                                item.remove("orientation");
                            }
                            known.put(change.get("name").stringValue(), item);
                        });
    }

    private static void change(Random random, AgentRoom room, int frame) {
        var items = new ArrayList<>(room.world.items());
        items.removeIf(item -> item.kind().equals("world"));
        for (Item item : items) {
            switch (random.nextInt(12)) {
                case 0, 1, 2 ->
                        item.physical()
                                .setLocation(
                                        random.nextDouble(-6, 6),
                                        random.nextDouble(-6, 6),
                                        random.nextDouble(-6, 6));
                case 3 ->
                        item.physical()
                                .setOrientation(
                                        random.nextGaussian(),
                                        random.nextGaussian(),
                                        random.nextGaussian(),
                                        1);
                case 4 -> item.physical().setOrientation(0, 0, 0, 1);
                case 5 -> item.semantic().set("mood", "mood " + random.nextInt(3));
                case 6 -> {
                    if (!item.name().equals("ada")) {
                        room.world.rename(item.id(), "renamed-" + frame + "-" + item.name());
                    }
                }
                case 7 -> {
                    if (!item.name().equals("ada")) {
                        room.world.remove(item.id());
                    }
                }
                default -> {}
            }
        }
        room.world.add(randomItem(random, "new-" + frame + "-"));
    }

    private static ItemDefinition randomItem(Random random, String name) {
        ItemDefinition.Builder item =
                ItemDefinition.named(name + random.nextInt(1_000_000))
                        .at(
                                random.nextDouble(-6, 6),
                                random.nextDouble(-6, 6),
                                random.nextDouble(-6, 6));
        turn(random, item);
        switch (random.nextInt(4)) {
            case 0 -> item.shape(Shape.sphere(random.nextDouble(0.1, 2)));
            case 1 ->
                    item.shape(Shape.box(random.nextDouble(0.1, 4), random.nextDouble(0.1, 4), 1));
            case 2 -> item.shape(Shape.plane(random.nextDouble(1, 6), random.nextDouble(1, 6)));
            default -> {}
        }
        if (random.nextBoolean()) {
            item.action(
                    new DeclaredAction(
                            "wind-up",
                            "Winds it.",
                            List.of(),
                            List.of(new Effect.SetSymbol("wound", new Operand.Symbol(true)))));
        }
        return item.build();
    }

    private static void turn(Random random, ItemDefinition.Builder item) {
        if (random.nextBoolean()) {
            item.orientation(
                    random.nextGaussian(), random.nextGaussian(), random.nextGaussian(), 1);
        }
    }

    private static Sensor randomSensor(Random random, String name) {
        Sensor sensor =
                random.nextInt(4) == 0
                        ? Sensor.touch(name)
                        : Sensor.sight(name, random.nextDouble(1, 12));
        if (!sensor.touch() && random.nextBoolean()) {
            sensor = sensor.withFieldOfView(random.nextDouble(0.2, 2 * Math.PI));
        }
        if (!sensor.touch() && random.nextBoolean()) {
            sensor = sensor.withLineOfSight();
        }
        if (random.nextBoolean()) {
            sensor = sensor.withSymbols(Set.of("mood", "name"));
        }
        if (random.nextBoolean()) {
            var aspects = EnumSet.allOf(Aspect.class);
            aspects.removeIf(aspect -> random.nextBoolean());
            sensor = sensor.withAspects(aspects);
        }
        return sensor;
    }

    private static Set<String> oracle(AgentRoom room, List<Sensor> sensors) {
        Item body = room.item("ada");
        var sensed = new TreeSet<String>();
        for (Item item : room.world.items()) {
            if (!item.kind().equals("world")
                    && (item == body
                            || sensors.stream()
                                    .anyMatch(sensor -> senses(room, sensor, body, item)))) {
                sensed.add(item.name());
            }
        }
        return new HashSet<>(sensed);
    }

    private static boolean senses(AgentRoom room, Sensor sensor, Item body, Item item) {
        double[] low = item.physical().boundsMin();
        double[] high = item.physical().boundsMax();
        if (sensor.touch()) {
            double[] own = body.physical().boundsMin();
            double[] ownHigh = body.physical().boundsMax();
            double square = 0;
            for (int i = 0; i < 3; i++) {
                double gap = Math.max(0, Math.max(own[i] - high[i], low[i] - ownHigh[i]));
                square += gap * gap;
            }
            return Math.sqrt(square) <= sensor.range();
        }
        double[] eye = body.physical().location();
        var points = new ArrayList<double[]>();
        points.add(
                new double[] {
                    nearest(eye[0], low[0], high[0]),
                    nearest(eye[1], low[1], high[1]),
                    nearest(eye[2], low[2], high[2])
                });
        points.add(
                new double[] {
                    (low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2
                });
        for (double x : new double[] {low[0], high[0]}) {
            for (double y : new double[] {low[1], high[1]}) {
                for (double z : new double[] {low[2], high[2]}) {
                    points.add(new double[] {x, y, z});
                }
            }
        }
        return points.stream().anyMatch(point -> isSeen(room, sensor, body, item, eye, point));
    }

    private static double nearest(double at, double low, double high) {
        return at < low ? low : at > high ? high : at;
    }

    private static boolean isSeen(
            AgentRoom room, Sensor sensor, Item body, Item item, double[] eye, double[] point) {
        double[] way = {point[0] - eye[0], point[1] - eye[1], point[2] - eye[2]};
        double distance = Math.hypot(Math.hypot(way[0], way[1]), way[2]);
        if (distance > sensor.range()) {
            return false;
        }
        if (sensor.fieldOfView() < Sensor.ALL_ROUND && distance > 0) {
            double[] ahead = rotate(body.physical().orientation(), new double[] {0, 0, 1});
            double cosine = (ahead[0] * way[0] + ahead[1] * way[1] + ahead[2] * way[2]) / distance;
            if (Math.acos(Math.clamp(cosine, -1, 1)) > sensor.fieldOfView() / 2) {
                return false;
            }
        }
        return !sensor.lineOfSight()
                || room.world.items().stream()
                        .filter(
                                other ->
                                        !other.kind().equals("world")
                                                && other != body
                                                && other != item
                                                && other.physical().shape() != Shape.none())
                        .noneMatch(other -> crosses(eye, way, other));
    }

    /** Returns q v q*, computed by two cross products. */
    private static double[] rotate(double[] q, double[] v) {
        double[] t = cross(q, v);
        double[] u = cross(q, t);
        return new double[] {
            v[0] + 2 * (q[3] * t[0] + u[0]),
            v[1] + 2 * (q[3] * t[1] + u[1]),
            v[2] + 2 * (q[3] * t[2] + u[2])
        };
    }

    private static double[] cross(double[] a, double[] b) {
        return new double[] {
            a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        };
    }

    /**
     * Returns whether a line crosses a box. It does so if it passes through one of the six sides.
     */
    private static boolean crosses(double[] eye, double[] way, Item box) {
        double[] low = box.physical().boundsMin();
        double[] high = box.physical().boundsMax();
        boolean holdsEye = true;
        for (int i = 0; i < 3; i++) {
            holdsEye &= low[i] <= eye[i] && eye[i] <= high[i];
        }
        if (holdsEye) {
            return false;
        }
        for (int axis = 0; axis < 3; axis++) {
            for (double side : new double[] {low[axis], high[axis]}) {
                double t = (side - eye[axis]) / way[axis];
                int b = (axis + 1) % 3;
                int c = (axis + 2) % 3;
                double atB = eye[b] + t * way[b];
                double atC = eye[c] + t * way[c];
                if (t > 1e-9
                        && t < 1 - 1e-9
                        && low[b] <= atB
                        && atB <= high[b]
                        && low[c] <= atC
                        && atC <= high[c]) {
                    return true;
                }
            }
        }
        return false;
    }

    private static List<String> sensed(Sensor sensor, ItemDefinition... items) throws IOException {
        return sensed(body(sensor).build(), items);
    }

    private static List<String> sensed(ItemDefinition body, ItemDefinition... items)
            throws IOException {
        try (AgentRoom room = room(body, items);
                TestClient ada = room.join("ada")) {
            var names = new ArrayList<String>();
            perceive(room, ada)
                    .get("items")
                    .forEach(item -> names.add(item.get("name").stringValue()));
            // The body comes last, because it was created last.
            names.sort((a, b) -> a.equals("ada") ? -1 : b.equals("ada") ? 1 : 0);
            return names;
        }
    }

    private static AgentRoom room(ItemDefinition body, ItemDefinition... items) throws IOException {
        return new AgentRoom(
                AgentRoom.CONFIG,
                new AgentPolicy(List.of(), Optional.of(body)),
                64,
                List.of(items));
    }

    private static JsonNode perceive(AgentRoom room, TestClient client) throws IOException {
        client.say("{'t':'perceive','id':1}").sync();
        room.step();
        return client.expect("perception");
    }

    private static ItemDefinition.Builder body(Sensor sensor) {
        return body("body", sensor);
    }

    private static ItemDefinition.Builder body(String name, Sensor sensor) {
        return ItemDefinition.named(name).shape(Shape.box(1, 1, 1)).sensor(sensor);
    }

    private static ItemDefinition ball(String name, double x, double y, double z) {
        return ItemDefinition.named(name).shape(Shape.sphere(0.5)).at(x, y, z).build();
    }

    private static ItemDefinition box(String name, double x, double y, double z, double size) {
        return ItemDefinition.named(name).shape(Shape.box(size, size, size)).at(x, y, z).build();
    }

    private static ItemDefinition place(String name, double x, double y, double z) {
        return ItemDefinition.named(name).at(x, y, z).build();
    }
}
