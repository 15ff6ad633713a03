// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.publish;

import reve.core.agent.perception.EventSubjects;
import reve.core.agent.perception.EventSubjects.Mention;
import reve.core.agent.perception.Observatory;
import reve.core.agent.perception.PerceivedItem;
import reve.core.agent.perception.Senses;
import reve.core.agent.perception.View;
import reve.core.space.Box;
import reve.core.space.BoxIndex;
import reve.core.space.Found;
import reve.core.world.ItemId;

import java.lang.foreign.MemorySegment;
import java.util.ArrayList;
import java.util.Collection;
import java.util.HashMap;
import java.util.HashSet;
import java.util.IdentityHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.stream.LongStream;

/**
 * Preselection of the clients that may receive an event. The cost of an event therefore depends on
 * the number of clients that perceive its items, and not on the number of agents. This class
 * selects the clients whose last view contains one of the items. It also selects the clients with a
 * sensor that may reach one of the items now. The selection may contain too many clients; {@link
 * Senses} makes the exact decision. For the event loop's thread only.
 */
final class EventRouting {

    private static final int AXES = 3;

    // The items in the last view of each agent with sensors.
    private final Map<Perceiver, Showing> showings = new IdentityHashMap<>();

    /**
     * For each item, the clients whose last view contains the item. The map is updated only when
     * there are events.
     */
    private final Map<ItemId, Set<Perceiver>> viewers = new HashMap<>();

    // The clients of this frame that have sensors. The next lists contain the clients without
    // sensors, those with sensors of unlimited reach, and those with sensors of limited reach.
    private final List<Perceiver> withSensors = new ArrayList<>();
    private final List<Perceiver> withoutSensors = new ArrayList<>();
    private final List<Perceiver> reachingAll = new ArrayList<>();
    private final List<Perceiver> within = new ArrayList<>();
    private boolean hasLockStep;

    /**
     * Boxes that contain the reach of each client's sensors. The keys are indices in {@link
     * #within}.
     */
    private final BoxIndex reaches = new BoxIndex();

    private double[] lows = {};
    private double[] highs = {};
    private long[] keys = {};
    private final Found found = new Found();

    private static final class Showing {
        private List<PerceivedItem> newest = List.of();

        /** The items for which {@link #viewers} contains this client. */
        private List<PerceivedItem> counted = List.of();
    }

    /** Records the view that was sent to a member. */
    void shows(Perceiver member, View view) {
        showings.computeIfAbsent(member, unknown -> new Showing()).newest = view.items();
    }

    /** Removes a member that has left. */
    void forget(Perceiver member) {
        Showing showing = showings.remove(member);
        if (showing != null) {
            update(member, showing.counted, List.of());
        }
    }

    private void countViewers() {
        showings.forEach(
                (member, showing) -> {
                    if (showing.counted != showing.newest) {
                        update(member, showing.counted, showing.newest);
                        showing.counted = showing.newest;
                    }
                });
    }

    /**
     * Updates {@link #viewers} after a change of the view of a member. Both lists are ordered by
     * id.
     */
    private void update(Perceiver member, List<PerceivedItem> before, List<PerceivedItem> now) {
        int old = 0;
        for (PerceivedItem seen : now) {
            while (old < before.size()
                    && before.get(old) != seen
                    && before.get(old).id().compareTo(seen.id()) < 0) {
                hides(member, before.get(old++).id());
            }
            if (old < before.size()
                    && (before.get(old) == seen || before.get(old).id().equals(seen.id()))) {
                old++;
            } else {
                viewers.computeIfAbsent(seen.id(), unknown -> new HashSet<>()).add(member);
            }
        }
        for (; old < before.size(); old++) {
            hides(member, before.get(old).id());
        }
    }

    private void hides(Perceiver member, ItemId item) {
        viewers.computeIfPresent(
                item,
                (id, all) -> {
                    all.remove(member);
                    return all.isEmpty() ? null : all;
                });
    }

    /** Loads the reach of the members' sensors in the frame that the observatory has read. */
    void locate(Collection<Perceiver> members, Observatory world) {
        countViewers();
        withSensors.clear();
        withoutSensors.clear();
        reachingAll.clear();
        within.clear();
        hasLockStep = false;
        for (Perceiver member : members) {
            hasLockStep |= member.isInLockStep();
            (member.hasSensors() ? withSensors : withoutSensors).add(member);
        }
        reserve(withSensors.size());
        for (Perceiver member : withSensors) {
            if (member.reach(world, lows, highs, AXES * within.size())) {
                within.add(member);
            } else {
                reachingAll.add(member);
            }
        }
        reaches.build(
                MemorySegment.ofArray(keys),
                MemorySegment.ofArray(lows),
                MemorySegment.ofArray(highs),
                within.size());
    }

    private void reserve(int count) {
        if (keys.length < count) {
            int room = Math.max(count, 2 * keys.length);
            lows = new double[AXES * room];
            highs = new double[AXES * room];
            keys = LongStream.range(0, room).toArray();
        }
    }

    /** Returns whether any member is in lock-step. */
    boolean hasLockStep() {
        return hasLockStep;
    }

    /** Returns the members without sensors, which receive all events. */
    List<Perceiver> withoutSensors() {
        return withoutSensors;
    }

    /** Returns the members with sensors that may receive an event. */
    Collection<Perceiver> of(EventSubjects subjects, Observatory world) {
        if (subjects.items().isEmpty()) {
            return withSensors;
        }
        var mayHear = new HashSet<>(reachingAll);
        for (Mention mention : subjects.items()) {
            if (mention.id().isEmpty()) {
                return withSensors; // the item no longer exists, so only its name is known
            }
            ItemId item = mention.id().get();
            mayHear.addAll(viewers.getOrDefault(item, Set.of()));
            Optional<Box> box = world.box(item);
            if (box.isPresent()) {
                reaches.inBox(box.get(), found);
                for (int i = 0; i < found.size(); i++) {
                    mayHear.add(within.get((int) found.key(i)));
                }
            }
        }
        return mayHear;
    }
}
