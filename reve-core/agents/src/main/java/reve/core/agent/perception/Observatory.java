// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;
import org.pcollections.TreePMap;

import reve.core.agent.protocol.Bytes;
import reve.core.agent.protocol.Encoding;
import reve.core.space.Box;
import reve.core.space.Found;
import reve.core.world.Instrument;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.TableSnapshot;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashMap;
import java.util.IdentityHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.BooleanSupplier;

/**
 * The newest frame that the publisher has read, and the computation of what sensors perceive in it.
 * Data that has not changed since the previous frame is represented by the same object. For the
 * event loop's thread only.
 */
public final class Observatory {

    /**
     * Factor by which searches extend a sensor's range to allow for rounding errors. An exact test
     * of the sensor follows each search.
     */
    private static final double WIDER = 1 + 1e-9;

    private static final int NO_ROW = -1;

    /**
     * Number of items that are tested between two checks of the clock, for sensors with a line of
     * sight.
     */
    private static final int LOOKS = 4;

    /** Number of items that are tested between two checks of the clock, for all other sensors. */
    private static final int TESTS = 64;

    /** Number of items that are encoded ahead between two checks of the clock. */
    private static final int ENCODED = 16;

    /** Maximum of {@link #path} [m]. If the sum were larger, rounding would lose small summands. */
    private static final double LONGEST_PATH = 1000;

    private final SensedWorld bodies = new SensedWorld();
    private final Found found = new Found();
    private final Measurements measurements = new Measurements(bodies);
    private final Weights weights;
    private final LidarScanner lidars = new LidarScanner(bodies, this::shapeIn);

    /** Bodies that last hid others from the eye of any body, for tests of single items. */
    private final Hiders hiders = new Hiders();

    private PMap<ItemId, ItemSymbols> symbols = TreePMap.empty();

    /** Numbers that the providers of sensors measured, by item and sensor. */
    private Map<ItemId, Map<String, double[]>> readings = Map.of();

    private Map<String, ItemId> idByName = Map.of();
    private View everything = new View(0, 0, List.of());

    /** Number of items, in the order of ids, that are encoded ahead. */
    private int ahead;

    /** The encodings of these items. */
    private Set<Encoding> aheadIn = Set.of();

    private final Bytes scratch = new Bytes();

    // This array and the next ones are indexed by the position of an item in the order of ids.
    private long[] inOrder = {};
    private EncodedItem[] items = {};
    private int[] rows = {};
    private PerceivedItem[] seen = {};

    /**
     * Perceived items by {@link Visibility}; null for items that no agent with this visibility has
     * sensed.
     */
    private final Map<Visibility, PerceivedItem[]> sensed = new HashMap<>();

    private final Map<Sensor, PerceivedItem[]> shownBy = new IdentityHashMap<>();

    // This array and the next ones are indexed by row in the table of bodies.
    private long[] ids = {};
    private int[] places = {};
    private PerceivedItem[] gathered = {};
    private int gatheredCount;

    /**
     * Version of the assignment of items to rows. It is incremented when items are added or
     * removed, or change their rows.
     */
    private long arrangement;

    /** Upper bound on the distance that any body has moved in this frame [m]. */
    private double moved;

    /** Sum of {@link #moved} over frames [m]. */
    private double path;

    /** Creates an object for a world in which no body has a strength. */
    public Observatory() {
        this(WorldPrototype.standard("si-f64"));
    }

    /**
     * Creates an object that has read no frame.
     *
     * @param prototype the prototype of the world whose frames are read
     */
    public Observatory(WorldPrototype prototype) {
        weights = new Weights(prototype);
    }

    /**
     * Reads a frame.
     *
     * @return false if the snapshot was overwritten meanwhile; the content of this object is then
     *     invalid
     */
    public boolean read(WorldSnapshot snapshot) {
        try {
            TableSnapshot table = snapshot.table(WorldPrototype.BODY);
            boolean others = snapshot.symbols() != symbols;
            if (others) {
                readItems(snapshot.symbols());
            }
            boolean rearranged =
                    others || table.ids().segment().mismatch(MemorySegment.ofArray(ids)) >= 0;
            if (rearranged) {
                findRows(table);
            }
            follow(table, rearranged);
            measurements.read(table);
            weights.read(snapshot);
            readings = snapshot.readings();
            lidars.read(table);
            readPlaces();
            everything = new View(snapshot.frame(), snapshot.timeSeconds(), List.of(seen));
        } catch (RuntimeException e) {
            if (snapshot.lost()) {
                forget();
                return false; // the data was overwritten while it was read
            }
            throw e;
        }
        if (snapshot.lost()) {
            forget();
            return false;
        }
        return true;
    }

    /** Discards all data, because it may be invalid. The next frame is then read completely. */
    private void forget() {
        ids = new long[0];
        symbols = TreePMap.empty();
        everything = new View(0, 0, List.of());
    }

    private void readItems(PMap<ItemId, ItemSymbols> now) {
        var known = new HashMap<ItemId, PerceivedItem>();
        for (PerceivedItem before : seen) {
            known.put(before.id(), before);
        }
        var present = new ArrayList<EncodedItem>(now.size());
        var names = new HashMap<String, ItemId>();
        var same = new ArrayList<@Nullable PerceivedItem>(now.size());
        for (ItemSymbols item : now.values()) {
            if (!item.kind().equals(WorldPrototype.WORLD)) {
                measurements.expect(item.sensors());
                lidars.expect(item.sensors());
                PerceivedItem before = known.get(item.id());
                same.add(before);
                present.add(
                        before != null && before.item().source() == item
                                ? before.item()
                                : new EncodedItem(item, before == null));
                names.put(item.name(), item.id());
            }
        }
        items = present.toArray(EncodedItem[]::new);
        inOrder = present.stream().mapToLong(item -> item.source().id().value()).toArray();
        seen = same.toArray(PerceivedItem[]::new);
        ahead = 0;
        sensed.clear();
        sensed.put(Visibility.EVERYTHING, seen);
        shownBy.clear();
        idByName = names;
        symbols = now;
        lidars.keep(present);
    }

    private void follow(TableSnapshot table, boolean rearranged) {
        moved = bodies.follow(table, rearranged);
        path += moved;
        if (!(path < LONGEST_PATH)) {
            path = 0;
            arrangement++;
        }
    }

    private void findRows(TableSnapshot table) {
        arrangement++;
        ids = table.ids().segment().toArray(ValueLayout.JAVA_LONG);
        rows = new int[items.length];
        places = new int[ids.length];
        for (int i = 0; i < items.length; i++) {
            rows[i] = table.rowOf(items[i].source().id());
            if (rows[i] != NO_ROW) {
                places[rows[i]] = i;
            }
        }
    }

    private void readPlaces() {
        for (int i = 0; i < items.length; i++) {
            if (seen[i] == null || !isSame(seen[i], items[i], rows[i])) {
                seen[i] =
                        new PerceivedItem(
                                items[i],
                                rows[i] == NO_ROW ? null : bodies.place(rows[i]),
                                Visibility.EVERYTHING,
                                false);
            }
        }
    }

    private boolean isSame(PerceivedItem before, EncodedItem now, int row) {
        double[] place = before.place();
        return before.item() == now
                && (row == NO_ROW
                        ? place == null
                        : place != null
                                && (!bodies.hasMoved(row, bodies.moment() - 1)
                                        || bodies.isAt(row, place)));
    }

    /**
     * Encodes new items, and new symbols of items. Otherwise the first perception of many items
     * would be encoded at once, while the clients of other worlds wait.
     *
     * @param encodings the encodings of the clients that perceive all items
     * @param isTimeLeft false if the event loop must do other work first
     * @return false if the time was too short; the next call continues
     */
    public boolean encode(Set<Encoding> encodings, BooleanSupplier isTimeLeft) {
        if (!aheadIn.equals(encodings)) {
            aheadIn = Set.copyOf(encodings);
            ahead = 0;
        }
        if (aheadIn.isEmpty()) {
            return true;
        }
        for (; ahead < items.length; ahead++) {
            if (ahead % ENCODED == 0 && !isTimeLeft.getAsBoolean()) {
                return false;
            }
            for (Encoding encoding : aheadIn) {
                encode(ahead, encoding);
            }
        }
        return true;
    }

    private void encode(int i, Encoding encoding) {
        if (items[i].markAhead(encoding)) {
            items[i].symbols(Optional.empty()).encode(encoding, scratch);
            if (items[i].isNew()) {
                seen[i].whole().encode(encoding, scratch);
            }
        }
    }

    /** Returns the view of all items, which clients without sensors receive. */
    public View everything() {
        return everything;
    }

    /** Begins to compute the relations of this frame's items. */
    void begin(FrameRelations relations) {
        relations.begin(everything, inOrder, rows, bodies);
    }

    Optional<ItemId> find(String name) {
        return Optional.ofNullable(idByName.get(name));
    }

    /**
     * Returns the items that one sensor of a body senses now, and the item of the body itself. The
     * list is in the order of ids.
     *
     * @param around items around the body that the sensor may reach; the caller keeps this object
     *     from frame to frame, and this method updates it
     * @param before the previous result; returned again if nothing has changed
     * @param isTimeLeft false if the caller must do other work first
     * @return empty if the time was too short; the next call in this frame continues
     */
    Optional<List<PerceivedItem>> sense(
            Sensor sensor,
            ItemId body,
            Surroundings around,
            List<PerceivedItem> before,
            BooleanSupplier isTimeLeft) {
        if (!gather(sensor, place(body), around, isTimeLeft)) {
            return Optional.empty();
        }
        return Optional.of(
                isGathered(before) ? before : List.of(Arrays.copyOf(gathered, gatheredCount)));
    }

    /**
     * Returns perceived items as the agent of a body perceives them.
     *
     * @param items items of this frame, in the order of their ids
     * @param before the previous result; returned again if nothing has changed
     */
    Weighed weigh(ItemId body, List<PerceivedItem> items, Weighed before) {
        int self = place(body);
        double strength =
                self < 0 ? Double.POSITIVE_INFINITY : weights.strength(this.items[self].source());
        long version = weights.version();
        if (items == before.from()
                && strength == before.strength()
                && version == before.version()) {
            return before;
        }
        if (weights.heaviest() <= strength) {
            return new Weighed(items, items, strength, version);
        }
        boolean isAnyHeavy = false;
        gatheredCount = 0;
        int at = 0;
        for (int i = 0; i < items.size(); i++) {
            PerceivedItem item = items.get(i);
            long id = item.id().value();
            while (at < inOrder.length && inOrder[at] < id) {
                at++;
            }
            boolean isHere = at < inOrder.length && inOrder[at] == id && rows[at] != NO_ROW;
            boolean heavy = isHere && at != self && weights.isTooHeavy(rows[at], strength);
            isAnyHeavy |= heavy;
            gather(heavy ? item.heavy() : item);
        }
        if (!isAnyHeavy) {
            return new Weighed(items, items, strength, version);
        }
        boolean isSame = isGathered(before.items());
        return new Weighed(
                items,
                isSame ? before.items() : List.of(Arrays.copyOf(gathered, gatheredCount)),
                strength,
                version);
    }

    /**
     * Returns the view of all items as the agent of a body perceives them.
     *
     * @param before the previous result for this body
     */
    public View everythingOf(ItemId body, View before) {
        if (before.frame() == everything.frame()) {
            return before;
        }
        Weighed known = new Weighed(List.of(), before.items(), Double.POSITIVE_INFINITY, -1);
        List<PerceivedItem> items = weigh(body, everything.items(), known).items();
        return items == everything.items()
                ? everything
                : new View(everything.frame(), everything.time(), items);
    }

    /**
     * Returns the reading of an instrument of a body in this frame.
     *
     * @param scan the progress of a lidar; the caller keeps it from call to call
     * @param isTimeLeft false if the caller must do other work first
     * @return empty if the time was too short; the next call in this frame continues. The list is
     *     empty if the body does not exist
     */
    Optional<List<Reading>> measure(
            Sensor sensor, ItemId body, Scan scan, BooleanSupplier isTimeLeft) {
        int row = row(body);
        if (row == NO_ROW) {
            return Optional.of(List.of());
        }
        long frame = everything.frame();
        double time = everything.time();
        if (sensor.instrument().orElseThrow() instanceof Instrument.Provided provided) {
            double[] numbers = readings.getOrDefault(body, Map.of()).get(sensor.name());
            return Optional.of(
                    numbers == null
                            ? List.of()
                            : List.of(Measurements.provided(sensor, provided, frame, numbers)));
        }
        if (!(sensor.instrument().orElseThrow() instanceof Instrument.Lidar lidar)) {
            return Optional.of(List.of(measurements.measure(sensor, body, row, frame, time)));
        }
        return lidars.scan(lidar, row, scan, isTimeLeft)
                ? Optional.of(List.of(lidars.reading(sensor, lidar, body, scan, frame, time)))
                : Optional.empty();
    }

    private Shape shapeIn(int row) {
        return items[places[row]].source().shape();
    }

    private boolean isGathered(List<PerceivedItem> items) {
        if (items.size() != gatheredCount) {
            return false;
        }
        for (int i = 0; i < gatheredCount; i++) {
            if (items.get(i) != gathered[i]) {
                return false;
            }
        }
        return true;
    }

    /**
     * Prepares the list of the items that a sensor may sense.
     *
     * @return false if the time was too short
     */
    private boolean gather(
            Sensor sensor, int eye, Surroundings around, BooleanSupplier isTimeLeft) {
        PerceivedItem[] shown =
                shownBy.computeIfAbsent(
                        sensor,
                        one ->
                                sensed.computeIfAbsent(
                                        Visibility.by(one),
                                        unknown -> new PerceivedItem[items.length]));
        gatheredCount = 0;
        if (!sensor.sensesItems()) {
            if (eye >= 0) {
                gather(seen[eye]);
            }
            return true;
        }
        if (eye < 0 || rows[eye] == NO_ROW || sensor.isUnlimited()) {
            for (int i = 0; i < items.length; i++) {
                gather(sensed(sensor, eye, i, shown, around.hiders));
            }
            return true;
        }
        if (!around.isBegun(bodies.moment())) {
            lookAround(sensor, rows[eye], around);
            around.begin(bodies.moment());
        }
        if (!testAll(sensor, eye, around, shown, isTimeLeft)) {
            return false;
        }
        boolean itself = false;
        for (int k = 0; k < around.count; k++) {
            int i = around.items[k];
            if (i > eye && !itself) {
                gather(seen[eye]);
                itself = true;
            }
            itself |= i == eye;
            gather(around.sensed[k]);
        }
        if (!itself) {
            gather(seen[eye]);
        }
        around.sensedIn = bodies.moment();
        return true;
    }

    /**
     * Tests which of the surrounding items the sensor senses. Skips items whose result cannot have
     * changed since its last perception.
     *
     * @return false if the time was too short
     */
    private boolean testAll(
            Sensor sensor,
            int eye,
            Surroundings around,
            PerceivedItem[] shown,
            BooleanSupplier isTimeLeft) {
        boolean all =
                sensor.lineOfSight()
                        ? bodies.haveAnyMoved(around.sensedIn)
                        : bodies.hasMoved(rows[eye], around.sensedIn);
        int interval = sensor.lineOfSight() ? LOOKS : TESTS;
        for (; around.tested < around.count; around.tested++) {
            int k = around.tested;
            int i = around.items[k];
            if (all || bodies.hasMoved(rows[i], around.sensedIn)) {
                if (k % interval == interval - 1 && !isTimeLeft.getAsBoolean()) {
                    return false;
                }
                around.sensed[k] = sensed(sensor, eye, i, shown, around.hiders);
            }
        }
        return true;
    }

    private void gather(@Nullable PerceivedItem item) {
        if (item != null) {
            if (gatheredCount == gathered.length) {
                gathered = Arrays.copyOf(gathered, Math.max(64, 2 * gatheredCount));
            }
            gathered[gatheredCount++] = item;
        }
    }

    /** Returns the perception of an item by a sensor, or null if the sensor does not reach it. */
    private @Nullable PerceivedItem sensed(
            Sensor sensor, int eye, int i, PerceivedItem[] shown, Hiders hiders) {
        if (i == eye) {
            return seen[i];
        }
        if (!senses(sensor, eye < 0 ? NO_ROW : rows[eye], rows[i], hiders)) {
            return null;
        }
        PerceivedItem known = shown[i];
        if (known == null || known.item() != seen[i].item() || known.place() != seen[i].place()) {
            known =
                    new PerceivedItem(
                            seen[i].item(), seen[i].place(), Visibility.by(sensor), false);
            shown[i] = known;
        }
        return known;
    }

    /**
     * Updates the list of items that a sensor of limited range may sense. The list is in the order
     * of ids, and may contain items that are out of reach.
     */
    private void lookAround(Sensor sensor, int eye, Surroundings around) {
        double range = sensor.range();
        if (Double.isInfinite(range)) {
            around.foundOnce();
            around.reserve(items.length);
            Arrays.setAll(around.items, i -> i);
            return;
        }
        if (around.holds(range, arrangement, path)) {
            return;
        }
        if (Surroundings.isWithinMargin(range, moved)) {
            bodies.find(eye, sensor, WIDER * range * (1 + Surroundings.MARGIN), found);
            around.foundIn(arrangement, path);
        } else {
            bodies.find(eye, sensor, WIDER * range, found);
            around.foundOnce();
        }
        around.reserve(found.size());
        for (int k = 0; k < around.count; k++) {
            around.items[k] = places[(int) found.key(k)];
        }
        Arrays.sort(around.items, 0, around.count);
    }

    /**
     * Returns the number of boxes that the searches for lines of sight have examined so far, for a
     * limit on this work.
     */
    public long examined() {
        return bodies.visited();
    }

    /** Returns whether any of a body's sensors senses an item now. */
    boolean senses(List<Sensor> sensors, ItemId body, ItemId item) {
        if (item.equals(body)) {
            return true;
        }
        int place = place(item);
        if (place < 0) {
            return false;
        }
        int eye = row(body);
        for (Sensor sensor : sensors) {
            if (senses(sensor, eye, rows[place], hiders)) {
                return true;
            }
        }
        return false;
    }

    /**
     * Computes a box that contains the body and everything that its sensors can reach.
     *
     * @param at index in both arrays at which the three numbers of the box are written
     * @return false if the reach of a sensor is unlimited
     */
    boolean reach(List<Sensor> sensors, ItemId body, double[] lows, double[] highs, int at) {
        int row = row(body);
        if (row == NO_ROW) {
            return false;
        }
        bodies.reach(row, lows, highs, at);
        for (Sensor sensor : sensors) {
            if (sensor.sensesItems()) {
                if (Double.isInfinite(sensor.range())) {
                    return false;
                }
                bodies.extendReach(sensor, WIDER * sensor.range(), row, lows, highs, at);
            }
        }
        return true;
    }

    /** Returns the bounding box of an item; empty for an item without a place, such as a spring. */
    public Optional<Box> box(ItemId item) {
        int row = row(item);
        return row == NO_ROW ? Optional.empty() : Optional.of(bodies.box(row));
    }

    private boolean senses(Sensor sensor, int eye, int row, Hiders known) {
        return sensor.isUnlimited()
                || eye != NO_ROW && row != NO_ROW && bodies.senses(sensor, eye, row, known);
    }

    private int row(ItemId id) {
        int place = place(id);
        return place < 0 ? NO_ROW : rows[place];
    }

    /** Returns the position of an item in the order of ids; negative if the item does not exist. */
    private int place(ItemId id) {
        return Arrays.binarySearch(inOrder, id.value());
    }
}
