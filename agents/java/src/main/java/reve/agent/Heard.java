// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The part that the agent heard of a text that another agent said in a frame.
 *
 * @param text the text; "…" replaces each lost word
 * @param lost number of lost words
 * @param speaker name of the speaker's body; empty if no sensor of the hearer senses this body
 * @param x x component of the unit vector from the hearer to the speaker, in the world's reference
 *     frame; 0 if both are at the same place
 * @param y y component of this vector
 * @param z z component of this vector
 * @param distance distance of the speaker [m]
 */
public record Heard(
        long frame,
        String text,
        int lost,
        Optional<String> speaker,
        double x,
        double y,
        double z,
        double distance) {

    /** Type of the event that contains a text that an agent hears. */
    static final String TYPE = "heard";

    /**
     * Reads an event.
     *
     * @throws AgentException if a field is missing or has the wrong type
     */
    static Heard in(WorldEvent event) {
        Map<String, Object> fields = event.fields();
        if (!(fields.get("text") instanceof String text)
                || !(fields.get("direction") instanceof List<?> direction)
                || direction.size() != 3
                || !(direction.get(0) instanceof Double x)
                || !(direction.get(1) instanceof Double y)
                || !(direction.get(2) instanceof Double z)
                || !(fields.get("distance") instanceof Double distance)) {
            throw AgentException.unexpected(event);
        }
        return new Heard(
                event.frame(),
                text,
                fields.get("lost") instanceof Double lost ? lost.intValue() : 0,
                fields.get("speaker") instanceof String name ? Optional.of(name) : Optional.empty(),
                x,
                y,
                z,
                distance);
    }
}
