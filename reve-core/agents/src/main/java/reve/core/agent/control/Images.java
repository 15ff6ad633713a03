// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import reve.core.agent.embodiment.Embodiment;
import reve.core.agent.embodiment.Rewound;
import reve.core.agent.port.WorldControl;
import reve.core.agent.port.WorldPort;
import reve.core.agent.protocol.Text;
import reve.core.text.Suggestion;
import reve.core.world.ActionRefused;
import reve.core.world.ItemId;
import reve.core.world.World;
import reve.core.world.WorldEvent;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.TreeMap;

/**
 * The states of a world that clients with the role control have saved in memory, by name. For the
 * world's thread, between frames.
 */
final class Images {

    /**
     * Maximum number of saved states. It is less than the maximum number of images of a world,
     * because `save` and `fork` also make images.
     */
    private static final int MAX_NAMES = 32;

    private final WorldPort port;
    private final Embodiment embodiment;
    private final Map<String, Kept> kept = new TreeMap<>();

    /**
     * A saved state of the world.
     *
     * @param bodies ids of the bodies in this state, by name of the agent
     */
    private record Kept(WorldControl.Image image, Map<String, ItemId> bodies) {}

    Images(WorldPort port, Embodiment embodiment) {
        this.port = port;
        this.embodiment = embodiment;
    }

    /**
     * Saves the present state of the world under a name. Replaces a saved state with the same name.
     *
     * @return the frame at whose end the state was saved
     */
    long keep(String name) throws ActionRefused {
        if (kept.size() >= MAX_NAMES && !kept.containsKey(name)) {
            throw new ActionRefused(
                    "too-many-images",
                    MAX_NAMES
                            + " images are kept, which is the most; a snapshot under one of"
                            + " their names replaces it: "
                            + kept.keySet());
        }
        Kept before = kept.remove(name);
        if (before != null) {
            before.image.close();
        }
        kept.put(name, new Kept(port.control().keep(), embodiment.bodies()));
        return port.loop().frame();
    }

    /**
     * Rewinds the world.
     *
     * @param agent name of the client that requests it
     * @param name name of the saved state; if empty, the beginning of the world
     */
    Rewound rewind(String agent, Optional<String> name, Optional<WorldControl.Image> beginning)
            throws ActionRefused {
        Kept target =
                name.isPresent() ? find(name.get()) : new Kept(beginning.orElseThrow(), Map.of());
        long frame = target.image.rewind();
        World world = port.loop().world();
        var fields = new LinkedHashMap<String, Object>();
        fields.put("agent", agent);
        name.ifPresent(image -> fields.put("image", image));
        world.raise(new WorldEvent(frame, "rewound", fields));
        return new Rewound(frame, embodiment.rewound(world, frame, target.bodies));
    }

    /** Returns the names of the saved states, in alphabetical order. */
    List<String> names() {
        return List.copyOf(kept.keySet());
    }

    private Kept find(String name) throws ActionRefused {
        Kept found = kept.get(name);
        if (found == null) {
            throw new ActionRefused(
                    "no-such-image",
                    "no image is called "
                            + Text.quote(name)
                            + (kept.isEmpty()
                                    ? "; none is kept: keep one with the command snapshot"
                                    : "; kept are "
                                            + String.join(", ", kept.keySet())
                                            + Suggestion.of(name, kept.keySet())));
        }
        return found;
    }
}
