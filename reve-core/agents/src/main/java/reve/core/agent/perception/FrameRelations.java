// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import org.jspecify.annotations.Nullable;

import reve.core.space.RelatedBoxes;
import reve.core.world.Sensor;
import reve.core.world.Shape;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.BitSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.function.BooleanSupplier;

/**
 * The spatial relations (near, on, inside, touching) between all items of one frame. They are
 * computed item by item, in slices of time if necessary. The input is a copy of the boxes of that
 * frame, so later frames do not change the result. For the event loop's thread only.
 */
final class FrameRelations {

    private static final List<String> NAMES = List.of("inside", "near", "on", "touching");
    private static final int NO_BOX = -1;

    /** Number of items between two checks of the clock. */
    private static final int BATCH = 16;

    private final RelatedBoxes boxes = new RelatedBoxes();
    private View everything = new View(-1, 0, List.of());

    // This array and the next ones are indexed by the position of an item in the order of ids.
    private long[] ids = {};
    private int[] boxOf = {};

    // This array and the next ones are indexed by box.
    private String[] names = {};
    private int[][] found = {};
    private List<Map<String, List<String>>> told = new ArrayList<>();
    private int done;

    /** View of all items with relations; null until it is requested for this frame. */
    private @Nullable View everythingRelated;

    /** Items of the last view of all items with relations, in the order of ids. */
    private List<PerceivedItem> related = List.of();

    /**
     * Begins with a new frame. Keeps the results of the previous frame if no box has changed.
     *
     * @param inOrder ids of the view's items, in ascending order; must not change
     * @param rows rows of the items in the table of bodies, negative for items that are not bodies
     */
    void begin(View view, long[] inOrder, int[] rows, SensedWorld bodies) {
        everything = view;
        everythingRelated = null;
        ids = inOrder;
        boxOf = new int[inOrder.length];
        double[] lows = new double[3 * inOrder.length];
        double[] highs = new double[3 * inOrder.length];
        String[] theirNames = new String[inOrder.length];
        int count = 0;
        for (int place = 0; place < inOrder.length; place++) {
            boxOf[place] = NO_BOX;
            if (rows[place] >= 0 && bodies.shape(rows[place]) != Shape.NONE) {
                boxOf[place] = count;
                theirNames[count] = view.items().get(place).name();
                bodies.copyBox(rows[place], lows, highs, 3 * count++);
            }
        }
        boolean renamed =
                count != names.length || !Arrays.equals(names, 0, count, theirNames, 0, count);
        if (renamed) {
            names = Arrays.copyOf(theirNames, count);
            found = new int[count][];
            told = new ArrayList<>(count);
        }
        if (boxes.load(lows, highs, count) || renamed) {
            done = 0;
        }
    }

    /** Returns whether this object contains the relations of the view's frame. */
    boolean isOf(View view) {
        return everything == view;
    }

    /**
     * Computes relations until the time is used up.
     *
     * @return true if all relations are computed
     */
    boolean advance(BooleanSupplier isTimeLeft) {
        while (done < names.length && isTimeLeft.getAsBoolean()) {
            advance();
        }
        return done == names.length;
    }

    /** Computes all remaining relations. */
    void complete() {
        while (done < names.length) {
            advance();
        }
    }

    private void advance() {
        int end = Math.min(names.length, done + BATCH);
        for (; done < end; done++) {
            boxes.find(done);
            int[] now = packed();
            if (done == told.size()) {
                told.add(named(now));
            } else if (!Arrays.equals(now, found[done])) {
                told.set(done, named(now));
            }
            found[done] = now;
        }
    }

    /**
     * Returns the result of the search in one array. The array contains the number of boxes for
     * each relation, then the boxes.
     */
    private int[] packed() {
        int size = RelatedBoxes.RELATIONS;
        for (int relation = 0; relation < RelatedBoxes.RELATIONS; relation++) {
            size += boxes.found(relation);
        }
        int[] packed = new int[size];
        int at = RelatedBoxes.RELATIONS;
        for (int relation = 0; relation < RelatedBoxes.RELATIONS; relation++) {
            packed[relation] = boxes.found(relation);
            for (int i = 0; i < packed[relation]; i++) {
                packed[at++] = boxes.found(relation, i);
            }
        }
        return packed;
    }

    private Map<String, List<String>> named(int[] packed) {
        var all = new LinkedHashMap<String, List<String>>();
        int at = RelatedBoxes.RELATIONS;
        for (int relation = 0; relation < RelatedBoxes.RELATIONS; relation++) {
            String[] others = new String[packed[relation]];
            for (int i = 0; i < others.length; i++) {
                others[i] = names[packed[at++]];
            }
            all.put(NAMES.get(relation), List.of(others));
        }
        return all;
    }

    /**
     * Returns the view with the relations between its items added. All relations must have been
     * computed.
     */
    View addTo(View view) {
        if (view == everything && everythingRelated != null) {
            return everythingRelated;
        }
        List<PerceivedItem> items = relate(view);
        View whole = new View(view.frame(), view.time(), items, view.readings());
        if (view == everything) {
            related = items;
            everythingRelated = whole;
        }
        return whole;
    }

    private List<PerceivedItem> relate(View view) {
        int[] boxes = new int[view.items().size()];
        var perceived = new BitSet();
        for (int i = 0; i < boxes.length; i++) {
            int place = Arrays.binarySearch(ids, view.items().get(i).id().value());
            boxes[i] = place < 0 ? NO_BOX : boxOf[place];
            if (boxes[i] != NO_BOX) {
                perceived.set(boxes[i]);
            }
        }
        boolean all = perceived.cardinality() == names.length;
        var items = new ArrayList<PerceivedItem>(boxes.length);
        int before = 0;
        for (int i = 0; i < boxes.length; i++) {
            PerceivedItem seen = view.items().get(i);
            PerceivedItem now =
                    boxes[i] != NO_BOX && seen.shown().has(Sensor.Aspect.SEMANTIC)
                            ? seen.with(relationsOf(boxes[i], seen.shown(), perceived, all))
                            : seen;
            while (before < related.size() && related.get(before).id().compareTo(seen.id()) < 0) {
                before++;
            }
            items.add(
                    before < related.size() && related.get(before).isSame(now)
                            ? related.get(before)
                            : now);
        }
        return List.copyOf(items);
    }

    private Map<String, List<String>> relationsOf(
            int box, Visibility shown, BitSet perceived, boolean all) {
        Map<String, List<String>> whole = told.get(box);
        if (shown.symbols().isEmpty() && (all || perceivesAll(found[box], perceived))) {
            return whole;
        }
        var part = new LinkedHashMap<String, List<String>>();
        int at = RelatedBoxes.RELATIONS;
        for (int relation = 0; relation < RelatedBoxes.RELATIONS; relation++) {
            String name = NAMES.get(relation);
            int end = at + found[box][relation];
            if (shown.symbols().map(symbols -> symbols.contains(name)).orElse(true)) {
                var others = new ArrayList<String>(end - at);
                for (int i = at; i < end; i++) {
                    if (perceived.get(found[box][i])) {
                        others.add(names[found[box][i]]);
                    }
                }
                part.put(name, others);
            }
            at = end;
        }
        return part;
    }

    private static boolean perceivesAll(int[] packed, BitSet perceived) {
        for (int i = RelatedBoxes.RELATIONS; i < packed.length; i++) {
            if (!perceived.get(packed[i])) {
                return false;
            }
        }
        return true;
    }
}
