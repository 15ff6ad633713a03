// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import org.jspecify.annotations.Nullable;

import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.Fragment;
import reve.core.agent.protocol.MessageWriter;
import reve.core.world.ItemId;
import reve.core.world.Sensor.Aspect;

import java.util.Arrays;
import java.util.List;
import java.util.Map;

/**
 * The perceived data of one item in one frame. An item that has not changed since the previous
 * frame is represented by the same object. The object is encoded once for all agents with equal
 * perceptions. Several threads may encode it at the same time, with equal results.
 */
public final class PerceivedItem {

    private static final double[] NOT_TURNED = {0, 0, 0, 1};

    private final EncodedItem item;
    private final double @Nullable [] place;
    private final Visibility shown;
    private final Map<String, List<String>> relations;
    private final boolean tooHeavy;
    private @Nullable Fragment whole;
    private @Nullable Change change;

    /**
     * The same data with the symbol {@code tooHeavy}, for agents whose bodies cannot lift the item.
     * Such agents share this object; null until the first of them perceives the item.
     */
    private @Nullable PerceivedItem heavy;

    /**
     * The cached difference from the state last sent. Immutable, so that other threads see it
     * completely.
     */
    private record Change(PerceivedItem from, Fragment told) {}

    /**
     * @param place location (3) [m] and orientation (4), null for an item without place; must not
     *     change
     * @param tooHeavy whether the item is too heavy for the body of the agent
     */
    PerceivedItem(EncodedItem item, double @Nullable [] place, Visibility shown, boolean tooHeavy) {
        this(item, place, shown, Map.of(), tooHeavy);
    }

    private PerceivedItem(
            EncodedItem item,
            double @Nullable [] place,
            Visibility shown,
            Map<String, List<String>> relations,
            boolean tooHeavy) {
        this.item = item;
        this.place = place;
        this.shown = shown;
        this.relations = relations;
        this.tooHeavy = tooHeavy;
    }

    /** Returns a copy with relations: names of items by relation. */
    PerceivedItem with(Map<String, List<String>> itsRelations) {
        return new PerceivedItem(item, place, shown, itsRelations, tooHeavy);
    }

    /**
     * Returns the data with the symbol {@code tooHeavy}, for agents whose bodies cannot lift the
     * item. Returns this object if the agent does not perceive this symbol.
     */
    PerceivedItem heavy() {
        if (tooHeavy || !shown.hasSymbol(Weights.TOO_HEAVY)) {
            return this;
        }
        if (heavy == null) {
            heavy = new PerceivedItem(item, place, shown, relations, true);
        }
        return heavy;
    }

    /** Returns whether the data marks the item as too heavy for the body of the agent. */
    boolean isTooHeavy() {
        return tooHeavy;
    }

    EncodedItem item() {
        return item;
    }

    double @Nullable [] place() {
        return place;
    }

    Visibility shown() {
        return shown;
    }

    /** Returns the relations; empty unless the agent requested them. */
    Map<String, List<String>> relations() {
        return relations;
    }

    /** Returns the id of the item. */
    public ItemId id() {
        return item.source().id();
    }

    /** Returns the name of the item. */
    public String name() {
        return item.source().name();
    }

    /** Returns whether both objects encode to the same data. */
    boolean isSame(PerceivedItem other) {
        return item == other.item
                && place == other.place
                && shown.equals(other.shown)
                && tooHeavy == other.tooHeavy
                && relations.equals(other.relations);
    }

    /**
     * Returns whether the item must be sent completely. The result is true if {@code before} is
     * another item or shows other aspects.
     */
    boolean isNewTo(PerceivedItem before) {
        return !name().equals(before.name())
                || !shown.equals(before.shown)
                || (place == null) != (before.place == null);
    }

    boolean isChanged(PerceivedItem before) {
        return isMoved(before, 0, 7) || hasOtherSymbols(before) || hasOtherActions(before);
    }

    /** Returns all perceived data, encoded. */
    Fragment whole() {
        Fragment known = whole;
        if (known == null) {
            known = new Fragment(this::writeWhole);
            whole = known;
        }
        return known;
    }

    /** Returns the name and the data that differs from {@code before}, encoded. */
    Fragment changeFrom(PerceivedItem before) {
        Change known = change;
        if (known == null || known.from != before) {
            known = new Change(before, new Fragment(writer -> writeChange(writer, before)));
            change = known;
            before.change = null; // a reference would keep all earlier versions in memory
        }
        return known.told;
    }

    private boolean isMoved(PerceivedItem before, int first, int count) {
        return shown.has(Aspect.PHYSICAL)
                && place != null
                && before.place != null
                && place != before.place
                && !Arrays.equals(place, first, first + count, before.place, first, first + count);
    }

    private boolean hasOtherSymbols(PerceivedItem before) {
        return shown.has(Aspect.SEMANTIC)
                && (tooHeavy != before.tooHeavy
                        || !relations.equals(before.relations)
                        || item != before.item && !Arrays.equals(symbols(), before.symbols()));
    }

    private byte[] symbols() {
        return item.symbols(shown.symbols()).in(Encoding.JSON);
    }

    private boolean hasOtherActions(PerceivedItem before) {
        return shown.has(Aspect.ACCESS)
                && item.source().actions() != before.item.source().actions();
    }

    private void writeWhole(MessageWriter writer) {
        double[] known = shown.has(Aspect.PHYSICAL) ? place : null;
        boolean turned = known != null && !Arrays.equals(known, 3, 7, NOT_TURNED, 0, 4);
        boolean access = shown.has(Aspect.ACCESS);
        write(
                writer,
                new Fields(
                        known != null,
                        turned,
                        shown.has(Aspect.SEMANTIC),
                        access,
                        access && !item.needs().isEmpty(),
                        access && !item.source().capabilities().isEmpty()));
    }

    private void writeChange(MessageWriter writer, PerceivedItem before) {
        boolean actions = hasOtherActions(before);
        write(
                writer,
                new Fields(
                        isMoved(before, 0, 3),
                        isMoved(before, 3, 4),
                        hasOtherSymbols(before),
                        actions,
                        actions && !item.needs().equals(before.item.needs()),
                        false));
    }

    /** The fields of an item that are sent, in addition to its name. */
    private record Fields(
            boolean location,
            boolean orientation,
            boolean symbols,
            boolean actions,
            boolean needs,
            boolean capabilities) {

        int count() {
            return count(location)
                    + count(orientation)
                    + count(symbols)
                    + count(actions)
                    + count(needs)
                    + count(capabilities);
        }

        private static int count(boolean field) {
            return field ? 1 : 0;
        }
    }

    private void write(MessageWriter writer, Fields fields) {
        writer.beginMap(1 + fields.count());
        writer.key("name");
        writer.text(name());
        if (fields.location && place != null) {
            writer.key("location");
            writer.numbers(place, 0, 3);
        }
        if (fields.orientation && place != null) {
            writer.key("orientation");
            writer.numbers(place, 3, 4);
        }
        if (fields.symbols) {
            writer.key("symbols");
            writeSymbols(writer);
        }
        if (fields.actions) {
            writer.key("actions");
            writer.fragment(item.actions());
        }
        if (fields.needs) {
            writer.key("needs");
            writer.value(item.needs());
        }
        if (fields.capabilities) {
            writer.key("capabilities");
            writer.value(item.source().capabilities());
        }
        writer.endMap();
    }

    private void writeSymbols(MessageWriter writer) {
        if (relations.isEmpty() && !tooHeavy) {
            writer.fragment(item.symbols(shown.symbols()));
        } else {
            Map<String, Object> symbols = item.symbolValues(shown.symbols());
            if (tooHeavy) {
                symbols.putIfAbsent(Weights.TOO_HEAVY, true); // a symbol of the designer goes first
            }
            symbols.putAll(relations);
            writer.value(symbols);
        }
    }
}
