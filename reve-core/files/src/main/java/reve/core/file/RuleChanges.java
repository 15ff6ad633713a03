// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.rule.Rule;

import tools.jackson.databind.json.JsonMapper;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.Predicate;

/**
 * The differences between the rules of a running world and the rules of its world file. A journal
 * contains them. {@link EditReader#rules(List, RuleChanges, java.util.function.Consumer)} makes the
 * changes. Immutable.
 *
 * @param changes at most one change for each symbol, in the order in which they are made
 */
public record RuleChanges(List<Change> changes) {
    /** No changes. */
    public static final RuleChanges NONE = new RuleChanges(List.of());

    /**
     * A change of one rule.
     *
     * @param symbol name of the symbol that the rule computes
     * @param rule the rule in the form of a world file, in JSON; empty if the rule is removed
     * @param isLast true if the rule becomes the last one. Otherwise it takes the place of the
     *     earlier rule of its symbol
     */
    public record Change(String symbol, Optional<String> rule, boolean isLast) {}

    /** Copies the list. */
    public RuleChanges {
        changes = List.copyOf(changes);
    }

    /** Returns whether the world has the rules of its world file. */
    public boolean isEmpty() {
        return changes.isEmpty();
    }

    /** Returns the changes that make one list of rules out of another one. */
    public static List<Change> between(List<Rule> before, List<Rule> after) {
        Map<String, Integer> places = new HashMap<>();
        for (int i = 0; i < before.size(); i++) {
            places.put(before.get(i).symbol(), i);
        }
        Set<String> left = new HashSet<>();
        after.forEach(rule -> left.add(rule.symbol()));
        List<Change> changes = new ArrayList<>();
        for (Rule rule : before) {
            if (!left.contains(rule.symbol())) {
                changes.add(new Change(rule.symbol(), Optional.empty(), false));
            }
        }
        int last = -1;
        boolean isInPlace = true;
        for (Rule rule : after) {
            int place = places.getOrDefault(rule.symbol(), -1);
            isInPlace &= place > last;
            if (!isInPlace) {
                changes.add(new Change(rule.symbol(), Optional.of(text(rule)), true));
                continue;
            }
            last = place;
            Rule earlier = before.get(place);
            if (rule != earlier && !text(rule).equals(text(earlier))) {
                changes.add(new Change(rule.symbol(), Optional.of(text(rule)), false));
            }
        }
        return changes;
    }

    private static String text(Rule rule) {
        return JsonMapper.shared().writeValueAsString(WorldWriter.rule(rule));
    }

    /**
     * Returns these changes followed by further ones. A later change of a rule replaces an earlier
     * one, so the number of changes is limited by the number of rules.
     *
     * @param isInFile whether the world file has a rule for a symbol. The removal of any other rule
     *     leaves no change
     */
    public RuleChanges with(List<Change> made, Predicate<String> isInFile) {
        if (made.isEmpty()) {
            return this;
        }
        Map<String, Change> now = new LinkedHashMap<>();
        changes.forEach(change -> now.put(change.symbol(), change));
        for (Change change : made) {
            String symbol = change.symbol();
            Change earlier = now.get(symbol);
            if (change.rule().isPresent() && !change.isLast()) {
                boolean isLast = earlier != null && earlier.isLast();
                now.put(symbol, new Change(symbol, change.rule(), isLast));
                continue;
            }
            now.remove(symbol);
            if (change.rule().isPresent() || isInFile.test(symbol)) {
                now.put(symbol, change);
            }
        }
        return new RuleChanges(List.copyOf(now.values()));
    }

    /** Returns the symbols of the changed rules. */
    public Set<String> symbols() {
        Set<String> symbols = new HashSet<>();
        changes.forEach(change -> symbols.add(change.symbol()));
        return symbols;
    }
}
