package reve.core.agent;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import org.pcollections.PMap;
import org.pcollections.TreePMap;
import reve.core.agent.View.Seen;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.Relations;
import reve.core.world.Sensor;
import reve.core.world.TableSnapshot;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

/**
 * The newest frame as the publisher has read it: all that there is to perceive, and what sensors make of it. What
 * did not change since the frame before is the same object as there. The event loop's thread.
 */
final class Observatory {

    private static final List<String> RELATIONS = Relations.NAMES.stream().sorted().toList();

    private final SensedWorld bodies = new SensedWorld();
    private PMap<ItemId, ItemSymbols> symbols = TreePMap.empty();
    private Map<ItemId, EncodedItem> encoded = new HashMap<>();
    private Map<String, ItemId> idByName = new HashMap<>();
    private Map<ItemId, Seen> seen = new HashMap<>();
    private int[] rows = {};
    private View everything = new View(0, 0, List.of());

    /** Reads a frame. @return false if the snapshot was lost meanwhile; then nothing here is to be used */
    boolean read(WorldSnapshot snapshot) {
        try {
            readSymbols(snapshot.symbols());
            TableSnapshot table = snapshot.table(WorldPrototype.BODY);
            bodies.load(table);
            readItems(snapshot, table);
        } catch (RuntimeException e) {
            if (snapshot.lost()) {
                return false; // what we read was being overwritten, and cannot make sense
            }
            throw e;
        }
        return !snapshot.lost();
    }

    private void readSymbols(PMap<ItemId, ItemSymbols> now) {
        if (now == symbols) {
            return;
        }
        var known = new HashMap<ItemId, EncodedItem>();
        var names = new HashMap<String, ItemId>();
        for (ItemSymbols item : now.values()) {
            if (!item.kind().equals(WorldPrototype.WORLD)) {
                EncodedItem before = encoded.get(item.id());
                known.put(item.id(), before != null && before.source() == item ? before : new EncodedItem(item));
                names.put(item.name(), item.id());
            }
        }
        encoded = known;
        idByName = names;
        symbols = now;
    }

    private void readItems(WorldSnapshot snapshot, TableSnapshot table) {
        var items = new ArrayList<Seen>(encoded.size());
        var all = new HashMap<ItemId, Seen>(2 * encoded.size());
        if (rows.length < encoded.size()) {
            rows = new int[2 * encoded.size()];
        }
        for (ItemSymbols item : symbols.values()) {
            EncodedItem now = encoded.get(item.id());
            if (now != null) {
                int row = table.rowOf(item.id());
                rows[items.size()] = row;
                Seen before = seen.get(item.id());
                Seen after = before != null && isSame(before, now, row) ? before
                        : new Seen(now, row < 0 ? null : bodies.place(row), Shown.EVERYTHING, Map.of());
                items.add(after);
                all.put(item.id(), after);
            }
        }
        seen = all;
        everything = new View(snapshot.frame(), snapshot.timeSeconds(), List.copyOf(items));
    }

    private boolean isSame(Seen before, EncodedItem now, int row) {
        double[] place = before.place();
        return before.item() == now && (row < 0 ? place == null : place != null && bodies.isAt(row, place));
    }

    /** All there is. */
    View everything() {
        return everything;
    }

    /**
     * A view of this frame with what is near, on, inside and touching among the items of the view.
     *
     * @return empty if the snapshot was lost meanwhile
     */
    Optional<View> withRelations(View view, WorldSnapshot snapshot) {
        try {
            var items = new ArrayList<Seen>(view.items().size());
            var names = new HashSet<String>();
            view.items().forEach(seen -> names.add(seen.name()));
            Relations relations = snapshot.relations();
            for (Seen seen : view.items()) {
                items.add(seen.shown().has(Sensor.Aspect.SEMANTIC)
                        ? seen.with(relationsOf(seen, relations, names)) : seen);
            }
            View related = new View(view.frame(), view.time(), List.copyOf(items));
            return snapshot.lost() ? Optional.empty() : Optional.of(related);
        } catch (RuntimeException e) {
            if (snapshot.lost()) {
                return Optional.empty();
            }
            throw e;
        }
    }

    private static Map<String, List<String>> relationsOf(Seen seen, Relations relations, Set<String> perceived) {
        var all = new LinkedHashMap<String, List<String>>();
        for (String relation : RELATIONS) {
            if (seen.shown().symbols().map(names -> names.contains(relation)).orElse(true)) {
                relations.of(seen.id(), relation).ifPresent(names ->
                        all.put(relation, names.stream().filter(perceived::contains).toList()));
            }
        }
        return all;
    }

    Optional<ItemId> find(String name) {
        return Optional.ofNullable(idByName.get(name));
    }

    /** What one sensor of a body senses now, and the body itself. */
    List<Seen> sense(Sensor sensor, ItemId body) {
        int eye = row(body);
        var sensed = new ArrayList<Seen>();
        for (int i = 0; i < everything.items().size(); i++) {
            Seen item = everything.items().get(i);
            if (item.id().equals(body)) {
                sensed.add(item);
            } else if (senses(sensor, eye, rows[i])) {
                sensed.add(new Seen(item.item(), item.place(), Shown.by(sensor), Map.of()));
            }
        }
        return sensed;
    }

    /** Whether any of a body's sensors senses an item now. */
    boolean senses(List<Sensor> sensors, ItemId body, ItemId item) {
        int eye = row(body);
        int row = row(item);
        return item.equals(body) || everything.indexOf(item) >= 0
                && sensors.stream().anyMatch(sensor -> senses(sensor, eye, row));
    }

    private boolean senses(Sensor sensor, int eye, int row) {
        return sensor.isUnlimited() || eye >= 0 && row >= 0 && bodies.senses(sensor, eye, row);
    }

    private int row(ItemId id) {
        int index = everything.indexOf(id);
        return index < 0 ? -1 : rows[index];
    }
}
