// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;
import java.util.Optional;

/**
 * The voice of a body, with which its agent speaks to agents whose bodies have a hearing {@link
 * Sensor}.
 *
 * <p>A word arrives at a distance d with the probability exp(-(d/fading)²). This formula follows
 * from two laws of acoustics. The mean intensity of a point source is proportional to 1/d². In a
 * room with many reflections, the intensity at a point has an exponential distribution around this
 * mean (M. R. Schroeder, Acustica 4, 1954). The {@code fading} is the distance at which the mean
 * intensity equals the lowest intensity that a listener understands.
 *
 * @param range greatest distance at which agents hear the voice [m], infinite for no limit
 * @param fading distance at which a word arrives with the probability 1/e [m]; infinite if no word
 *     is lost
 */
public record Voice(double range, double fading) {

    /** Name of the act with which an agent speaks. */
    public static final String SAY = "say";

    /** Maximum length of a text [characters]. */
    public static final int MAX_TEXT_LENGTH = 256;

    /**
     * Checks the distances.
     *
     * @throws IllegalArgumentException if a distance is not more than 0
     */
    public Voice {
        requireDistance("range", range);
        requireDistance("fading", fading);
    }

    /** Returns the probability that a word arrives at a distance [m] within the range. */
    public double clarity(double distance) {
        double ratio = distance / fading;
        return StrictMath.exp(-ratio * ratio); // StrictMath gives the same bits on each machine
    }

    private static void requireDistance(String name, double metres) {
        if (!(metres > 0)) {
            throw new IllegalArgumentException(name + ": " + metres + " m is not more than 0");
        }
    }

    /**
     * Checks that an item with a voice has no action {@link #SAY}, because this name is that of its
     * speech.
     *
     * @throws IllegalArgumentException naming the item
     */
    static void requireNoAction(String item, Optional<Voice> voice, List<Action> actions) {
        if (voice.isPresent() && actions.stream().anyMatch(each -> each.name().equals(SAY))) {
            throw new IllegalArgumentException(
                    "item "
                            + item
                            + " has a voice, so none of its actions may have the name `say`; rename"
                            + " this action, or leave out the voice");
        }
    }
}
