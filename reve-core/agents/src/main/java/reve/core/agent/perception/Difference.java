// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.agent.protocol.Bytes;
import reve.core.agent.protocol.MessageWriter;

import java.util.ArrayList;
import java.util.List;

/** The differences between two views: new, changed and missing items. Reusable; for one thread. */
public final class Difference {

    private final List<String> left = new ArrayList<>();
    private final List<PerceivedItem> entered = new ArrayList<>();

    /** Pairs of elements: the former and the present version of each changed item. */
    private final List<PerceivedItem> changed = new ArrayList<>();

    /** Compares two lists of items, both ordered by id. */
    void find(List<PerceivedItem> before, List<PerceivedItem> now) {
        left.clear();
        entered.clear();
        changed.clear();
        int old = 0;
        for (int i = 0; i < now.size(); i++) {
            PerceivedItem seen = now.get(i);
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

    private void compare(PerceivedItem before, PerceivedItem now) {
        if (now.isNewTo(before)) {
            left.add(before.name());
            entered.add(now);
        } else if (now.isChanged(before)) {
            changed.add(before);
            changed.add(now);
        }
    }

    /** Returns the number of lists that are not empty. Only such lists are encoded. */
    int lists() {
        return (left.isEmpty() ? 0 : 1) + (entered.isEmpty() ? 0 : 1) + (changed.isEmpty() ? 0 : 1);
    }

    void write(MessageWriter writer, Bytes out) {
        if (!left.isEmpty()) {
            writer.key("left");
            writer.value(left);
        }
        if (!entered.isEmpty()) {
            writer.key("entered");
            writer.beginList(entered.size());
            for (int i = 0; i < entered.size(); i++) {
                writer.fragment(entered.get(i).whole());
                PerceptionEncoder.requireSize(out);
            }
            writer.endList();
        }
        if (!changed.isEmpty()) {
            writer.key("changed");
            writer.beginList(changed.size() / 2);
            for (int i = 0; i < changed.size(); i += 2) {
                writer.fragment(changed.get(i + 1).changeFrom(changed.get(i)));
                PerceptionEncoder.requireSize(out);
            }
            writer.endList();
        }
    }
}
