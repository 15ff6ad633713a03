// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.ArrayList;
import java.util.List;
import java.util.Optional;

/**
 * The actions that agents can perform on an item, and the capabilities that the item has as the
 * body of an agent. For the world's thread only.
 */
public final class AccessAspect {

    private final Item item;

    AccessAspect(Item item) {
        this.item = item;
    }

    /** Returns all actions, in the order of their definition. */
    public List<Action> actions() {
        item.checkedRow();
        return item.symbols().actions();
    }

    /** Returns the capabilities that the item has as the body of an agent. */
    public List<String> capabilities() {
        item.checkedRow();
        return item.symbols().capabilities();
    }

    /** Returns the action of that name. */
    public Optional<Action> find(String name) {
        for (Action action : actions()) {
            if (action.name().equals(name)) {
                return Optional.of(action);
            }
        }
        return Optional.empty();
    }

    /**
     * Adds an action, or replaces the action of the same name.
     *
     * @throws IllegalArgumentException if the item has a voice and the action is named {@code say}
     */
    public void set(Action action) {
        Voice.requireNoAction(item.name(), item.voice(), List.of(action));
        change(action.name(), action);
    }

    /** Removes an action, if present. */
    public void remove(String name) {
        if (find(name).isPresent()) {
            change(name, null);
        }
    }

    private void change(String name, @Nullable Action to) {
        Action from = find(name).orElse(null);
        List<Action> changed = new ArrayList<>(actions());
        if (from == null && to != null) {
            changed.add(to);
        } else if (to != null) {
            changed.set(changed.indexOf(from), to);
        } else {
            changed.remove(from);
        }
        item.change(item.symbols().with(item.symbols().likeness().with(List.copyOf(changed))));
        item.world()
                .note(new WorldChange.Edited(item.id(), WorldChange.Aspect.ACCESS, name, from, to));
    }
}
