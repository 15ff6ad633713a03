package reve.core.world;

import java.util.List;
import java.util.Optional;

/** What agents can do with an item. World's thread only. */
public final class AccessAspect {

    private final Item item;

    AccessAspect(Item item) {
        this.item = item;
    }

    public List<Action> actions() {
        item.checkedRow();
        return item.symbols().actions();
    }

    public Optional<Action> find(String name) {
        return actions().stream().filter(action -> action.name().equals(name)).findFirst();
    }
}
