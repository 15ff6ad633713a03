// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.Fragment;
import reve.core.world.Action;
import reve.core.world.ItemSymbols;
import reve.core.world.Parameter;
import reve.core.world.ParameterType;

import java.util.EnumSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.SortedSet;
import java.util.concurrent.ConcurrentHashMap;

/** The encoded form of one version of an item's symbolic data. Each part is encoded only once. */
final class EncodedItem {

    private final ItemSymbols source;
    private final boolean isNew;
    private final Fragment actions;
    private final Map<Optional<SortedSet<String>>, Fragment> symbols = new ConcurrentHashMap<>();

    /** Encodings in which the data is encoded ahead. For the event loop's thread. */
    private final Set<Encoding> ahead = EnumSet.noneOf(Encoding.class);

    /**
     * @param isNew true for the first version of the item
     */
    EncodedItem(ItemSymbols source, boolean isNew) {
        this.source = source;
        this.isNew = isNew;
        this.actions = new Fragment(writer -> writer.value(actions(source)));
    }

    ItemSymbols source() {
        return source;
    }

    boolean isNew() {
        return isNew;
    }

    /**
     * Records that the data is encoded ahead; returns false if it was before. For the event loop's
     * thread.
     */
    boolean markAhead(Encoding encoding) {
        return ahead.add(encoding);
    }

    Fragment actions() {
        return actions;
    }

    /**
     * Returns the symbols of the item that a client perceives, encoded.
     *
     * @param which names of the symbols that a client perceives; empty for all
     */
    Fragment symbols(Optional<SortedSet<String>> which) {
        return symbols.computeIfAbsent(
                which, names -> new Fragment(writer -> writer.value(symbolValues(names))));
    }

    /** Returns the values of the perceived symbols, by name. */
    Map<String, Object> symbolValues(Optional<SortedSet<String>> which) {
        Map<String, Object> perceived = source.symbols();
        which.ifPresent(perceived.keySet()::retainAll);
        return perceived;
    }

    /**
     * Returns the capabilities that the item's actions need, by name of the action. Actions that
     * need no capability are omitted.
     */
    Map<String, Object> needs() {
        var needs = new LinkedHashMap<String, Object>();
        source.actions().stream()
                .filter(action -> !action.needs().isEmpty())
                .forEach(action -> needs.put(action.name(), List.copyOf(action.needs())));
        return needs;
    }

    private static Map<String, Object> actions(ItemSymbols item) {
        var actions = new LinkedHashMap<String, Object>();
        for (Action action : item.actions()) {
            var parameters = new LinkedHashMap<String, Object>();
            action.parameters()
                    .forEach(parameter -> parameters.put(parameter.name(), parameter(parameter)));
            actions.put(action.name(), parameters);
        }
        return actions;
    }

    private static Map<String, Object> parameter(Parameter parameter) {
        var fields = new LinkedHashMap<String, Object>();
        fields.put(
                "type",
                switch (parameter.type()) {
                    case NUMBER -> "number";
                    case TEXT -> "text";
                    case TRUTH -> "truth";
                    case ITEM -> "item";
                });
        if (parameter.type() == ParameterType.NUMBER) {
            fields.put("components", parameter.components());
            fields.put("unit", parameter.unit().symbol());
            putBound(fields, "min", parameter.minimum());
            putBound(fields, "max", parameter.maximum());
        }
        return fields;
    }

    private static void putBound(Map<String, Object> fields, String name, double bound) {
        if (Double.isFinite(bound)) {
            fields.put(name, bound);
        }
    }
}
