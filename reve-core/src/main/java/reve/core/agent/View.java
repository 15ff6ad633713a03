package reve.core.agent;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Map;
import org.jspecify.annotations.Nullable;
import reve.core.world.ItemId;
import reve.core.world.Sensor.Aspect;

/**
 * What an agent perceives in one frame, in the order of the items' ids; and how that is told, whole or as the
 * difference to what it was told before. Immutable.
 *
 * @param time of the world [s]
 */
record View(long frame, double time, List<Seen> items) {

    private static final double[] NOT_TURNED = {0, 0, 0, 1};

    /**
     * One item in one frame.
     *
     * @param place location (3) [m] and orientation (4), null for what has no place; never changed
     * @param relations names of items by relation, where the agent asked for them
     */
    record Seen(EncodedItem item, double @Nullable [] place, Shown shown, Map<String, List<String>> relations) {

        Seen with(Map<String, List<String>> itsRelations) {
            return new Seen(item, place, shown, itsRelations);
        }

        ItemId id() {
            return item.source().id();
        }

        String name() {
            return item.source().name();
        }

        /** Another item, or one of which something else is perceived: it is told as if new. */
        boolean isNewTo(Seen before) {
            return !name().equals(before.name()) || !shown.equals(before.shown)
                    || (place == null) != (before.place == null);
        }

        boolean isMoved(Seen before, int first, int count) {
            return shown.has(Aspect.PHYSICAL) && place != null && before.place != null && place != before.place
                    && !Arrays.equals(place, first, first + count, before.place, first, first + count);
        }

        boolean hasOtherSymbols(Seen before) {
            return shown.has(Aspect.SEMANTIC) && (!relations.equals(before.relations) || item != before.item
                    && !item.symbols(shown.symbols()).json().equals(before.item.symbols(shown.symbols()).json()));
        }

        boolean hasOtherActions(Seen before) {
            return shown.has(Aspect.ACCESS) && item.source().actions() != before.item.source().actions();
        }

        boolean isChanged(Seen before) {
            return isMoved(before, 0, 7) || hasOtherSymbols(before) || hasOtherActions(before);
        }
    }

    /** The fields of a perception behind its {@code t} and {@code id}. */
    record Told(int fields, byte[] bytes) {}

    /** Where an item is in the list; negative if it is not there. */
    int indexOf(ItemId id) {
        int low = 0;
        int high = items.size() - 1;
        while (low <= high) {
            int middle = (low + high) >>> 1;
            int order = items.get(middle).id().compareTo(id);
            if (order == 0) {
                return middle;
            }
            if (order < 0) {
                low = middle + 1;
            } else {
                high = middle - 1;
            }
        }
        return -1;
    }

    boolean holds(String name) {
        return items.stream().anyMatch(seen -> seen.name().equals(name));
    }

    /** All of it. */
    Told whole(Encoding encoding) {
        return new Told(3, encoding.fields(3, writer -> {
            writeTime(writer);
            writer.key("items");
            writer.beginList(items.size());
            items.forEach(seen -> writeWhole(writer, seen));
            writer.endList();
        }));
    }

    /** What is different from what was told before. */
    Told since(View before, Encoding encoding) {
        var difference = new Difference(before.items, items);
        int fields = 3 + difference.lists();
        return new Told(fields, encoding.fields(fields, writer -> {
            writeTime(writer);
            writer.key("since");
            writer.integer(before.frame);
            difference.write(writer);
        }));
    }

    private void writeTime(MessageWriter writer) {
        writer.key("frame");
        writer.integer(frame);
        writer.key("time");
        writer.number(time);
    }

    private static void writeWhole(MessageWriter writer, Seen seen) {
        double[] place = seen.shown.has(Aspect.PHYSICAL) ? seen.place : null;
        boolean turned = place != null && !Arrays.equals(place, 3, 7, NOT_TURNED, 0, 4);
        boolean access = seen.shown.has(Aspect.ACCESS);
        new Fields(seen, place != null, turned, seen.shown.has(Aspect.SEMANTIC), access,
                access && !seen.item.needs().isEmpty(), access && !seen.item.source().capabilities().isEmpty())
                .write(writer);
    }

    private static void writeChange(MessageWriter writer, Seen before, Seen now) {
        boolean actions = now.hasOtherActions(before);
        new Fields(now, now.isMoved(before, 0, 3), now.isMoved(before, 3, 4), now.hasOtherSymbols(before), actions,
                actions && !now.item.needs().equals(before.item.needs()), false).write(writer);
    }

    /** Which fields of an item are told. */
    private record Fields(Seen seen, boolean location, boolean orientation, boolean symbols, boolean actions,
            boolean needs, boolean capabilities) {

        void write(MessageWriter writer) {
            writer.beginMap(1 + count(location) + count(orientation) + count(symbols) + count(actions)
                    + count(needs) + count(capabilities));
            writer.key("name");
            writer.text(seen.name());
            writePlace(writer);
            if (symbols) {
                writer.key("symbols");
                writeSymbols(writer);
            }
            if (actions) {
                writer.key("actions");
                writer.fragment(seen.item.actions());
            }
            if (needs) {
                writer.key("needs");
                writer.value(seen.item.needs());
            }
            if (capabilities) {
                writer.key("capabilities");
                writer.value(seen.item.source().capabilities());
            }
            writer.endMap();
        }

        private void writePlace(MessageWriter writer) {
            if (location && seen.place != null) {
                writer.key("location");
                writer.numbers(seen.place, 0, 3);
            }
            if (orientation && seen.place != null) {
                writer.key("orientation");
                writer.numbers(seen.place, 3, 4);
            }
        }

        private void writeSymbols(MessageWriter writer) {
            if (seen.relations.isEmpty()) {
                writer.fragment(seen.item.symbols(seen.shown.symbols()));
            } else {
                Map<String, Object> symbols = seen.item.symbolValues(seen.shown.symbols());
                symbols.putAll(seen.relations);
                writer.value(symbols);
            }
        }
    }

    private static int count(boolean field) {
        return field ? 1 : 0;
    }

    /** Two lists in the order of ids, merged. */
    private static final class Difference {

        private final List<Seen> entered = new ArrayList<>();
        private final List<Seen> changedFrom = new ArrayList<>();
        private final List<Seen> changedTo = new ArrayList<>();
        private final List<String> left = new ArrayList<>();

        Difference(List<Seen> before, List<Seen> now) {
            int old = 0;
            for (Seen seen : now) {
                for (; old < before.size() && before.get(old).id().compareTo(seen.id()) < 0; old++) {
                    left.add(before.get(old).name());
                }
                if (old < before.size() && before.get(old).id().equals(seen.id())) {
                    compare(before.get(old), seen);
                    old++;
                } else {
                    entered.add(seen);
                }
            }
            for (; old < before.size(); old++) {
                left.add(before.get(old).name());
            }
        }

        private void compare(Seen before, Seen now) {
            if (now == before) {
                return;
            }
            if (now.isNewTo(before)) {
                left.add(before.name());
                entered.add(now);
            } else if (now.isChanged(before)) {
                changedFrom.add(before);
                changedTo.add(now);
            }
        }

        /** How many of the lists hold anything; the others are not told. */
        int lists() {
            return count(!left.isEmpty()) + count(!entered.isEmpty()) + count(!changedTo.isEmpty());
        }

        void write(MessageWriter writer) {
            if (!left.isEmpty()) {
                writer.key("left");
                writer.value(left);
            }
            if (!entered.isEmpty()) {
                writer.key("entered");
                writer.beginList(entered.size());
                entered.forEach(seen -> writeWhole(writer, seen));
                writer.endList();
            }
            if (!changedTo.isEmpty()) {
                writer.key("changed");
                writer.beginList(changedTo.size());
                for (int i = 0; i < changedTo.size(); i++) {
                    writeChange(writer, changedFrom.get(i), changedTo.get(i));
                }
                writer.endList();
            }
        }
    }
}
