package reve.core.agent;

import java.util.ArrayList;
import java.util.List;
import reve.core.world.ItemId;

/**
 * What an agent perceives in one frame, in the order of the items' ids; and how that is told, whole or as the
 * difference to what it was told before. Immutable.
 *
 * @param time of the world [s]
 */
record View(long frame, double time, List<Seen> items) {

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

    /** All of it. @param scratch memory to write in */
    Told whole(Encoding encoding, Bytes scratch) {
        return new Told(3, encoding.fields(scratch, writer -> {
            writeTime(writer);
            writer.key("items");
            writer.beginList(items.size());
            items.forEach(seen -> writer.fragment(seen.whole()));
            writer.endList();
        }));
    }

    /** What is different from what was told before. @param scratch memory to write in */
    Told since(View before, Encoding encoding, Bytes scratch) {
        var difference = new Difference(before.items, items);
        int fields = 3 + difference.lists();
        return new Told(fields, encoding.fields(scratch, writer -> {
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

    private static int count(boolean field) {
        return field ? 1 : 0;
    }

    /** Two lists in the order of ids, merged. */
    private static final class Difference {

        private final List<Seen> entered = new ArrayList<>(0);
        private final List<Fragment> changed = new ArrayList<>();
        private final List<String> left = new ArrayList<>(0);

        Difference(List<Seen> before, List<Seen> now) {
            int old = 0;
            for (Seen seen : now) {
                if (old < before.size() && before.get(old) == seen) {
                    old++;
                    continue;
                }
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
            if (now.isNewTo(before)) {
                left.add(before.name());
                entered.add(now);
            } else if (now.isChanged(before)) {
                changed.add(now.changeFrom(before));
            }
        }

        /** How many of the lists hold anything; the others are not told. */
        int lists() {
            return count(!left.isEmpty()) + count(!entered.isEmpty()) + count(!changed.isEmpty());
        }

        void write(MessageWriter writer) {
            if (!left.isEmpty()) {
                writer.key("left");
                writer.value(left);
            }
            if (!entered.isEmpty()) {
                writer.key("entered");
                writer.beginList(entered.size());
                entered.forEach(seen -> writer.fragment(seen.whole()));
                writer.endList();
            }
            if (!changed.isEmpty()) {
                writer.key("changed");
                writer.beginList(changed.size());
                changed.forEach(writer::fragment);
                writer.endList();
            }
        }
    }
}
