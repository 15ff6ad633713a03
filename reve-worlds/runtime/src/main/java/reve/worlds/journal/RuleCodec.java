// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.file.RuleChanges;
import reve.core.image.Trees;

import tools.jackson.databind.JsonNode;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** The codec of changes of a world's rules as JSON. */
final class RuleCodec {
    /** The key of the changes in an image and in a frame. */
    static final String KEY = "rules";

    private RuleCodec() {}

    static List<Object> tree(List<RuleChanges.Change> changes) {
        List<Object> list = new ArrayList<>();
        for (RuleChanges.Change change : changes) {
            Map<String, Object> tree = new LinkedHashMap<>();
            tree.put("symbol", change.symbol());
            change.rule().ifPresent(rule -> tree.put("rule", rule));
            if (change.isLast()) {
                tree.put("last", true);
            }
            list.add(tree);
        }
        return list;
    }

    /** Returns the changes in an image or a frame; none if it was written before they existed. */
    static List<RuleChanges.Change> read(JsonNode tree) {
        return Trees.listIfAny(tree, KEY).stream()
                .map(
                        change ->
                                new RuleChanges.Change(
                                        Trees.text(change, "symbol"),
                                        change.has("rule")
                                                ? Optional.of(Trees.text(change, "rule"))
                                                : Optional.empty(),
                                        change.path("last").asBoolean(false)))
                .toList();
    }
}
