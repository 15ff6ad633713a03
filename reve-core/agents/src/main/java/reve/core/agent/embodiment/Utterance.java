// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import reve.core.agent.protocol.ServerMessage;
import reve.core.world.Action;
import reve.core.world.ActionRefused;
import reve.core.world.Arguments;
import reve.core.world.ItemId;
import reve.core.world.Parameter;
import reve.core.world.Voice;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * A text that an agent says in a frame, and the computation of the words that arrive at a hearer.
 * Each word arrives or is lost independently of the others. The result depends only on the
 * arguments: the pseudorandom numbers have a seed of world, frame, speaker, hearer and text, and
 * come from SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, Fast splittable pseudorandom number
 * generators, 2014). Immutable.
 */
final class Utterance {

    /** Replacement of a lost word. */
    static final String LOST = "…";

    private static final String TEXT = "text";
    private static final long STEP = 0x9e3779b97f4a7c15L;
    private static final Action SAY = new Saying();

    private final String world;
    private final long frame;
    private final ItemId speaker;
    private final double[] from;
    private final Voice voice;
    private final String text;
    private final int words;

    /** Description of the act {@code speak}, which the check of the arguments needs. */
    private record Saying() implements Action {
        @Override
        public String name() {
            return Voice.SAY;
        }

        @Override
        public String doc() {
            return "Speaks to the agents that hear the voice of the body.";
        }

        @Override
        public List<Parameter> parameters() {
            return List.of(Parameter.text(TEXT, "What to say."));
        }
    }

    /**
     * The part of the text that reaches one hearer.
     *
     * @param text the text that arrives, in which {@link #LOST} replaces each lost word
     * @param lost number of lost words
     */
    record Arrived(String text, int lost) {}

    /**
     * @param from location of the speaker (3) [m]
     */
    Utterance(String world, long frame, ItemId speaker, double[] from, Voice voice, String text) {
        this.world = world;
        this.frame = frame;
        this.speaker = speaker;
        this.from = from.clone();
        this.voice = voice;
        this.text = text;
        this.words = words(text).size() / 2;
    }

    /**
     * Returns the text of an act.
     *
     * @throws ActionRefused if the arguments are not exactly one text with at least one word and at
     *     most {@link Voice#MAX_TEXT_LENGTH} characters
     */
    static String textIn(Map<String, ?> arguments) throws ActionRefused {
        if (arguments.get(TEXT) instanceof String text
                && (text.length() > Voice.MAX_TEXT_LENGTH || text.isBlank())) {
            throw new ActionRefused(
                    "wrong-type",
                    "`text` of action say takes a text of at least one word and at most "
                            + Voice.MAX_TEXT_LENGTH
                            + " characters, found "
                            + (text.isBlank() ? "no word" : text.length() + " characters"));
        }
        return Arguments.check(SAY, arguments).text(TEXT);
    }

    /** Returns the distance from the speaker to a location (3) [m]. */
    double distance(double[] to) {
        double x = from[0] - to[0];
        double y = from[1] - to[1];
        double z = from[2] - to[2];
        return Math.sqrt(x * x + y * y + z * z);
    }

    /**
     * Returns the text that arrives at a hearer; empty if the hearer is out of range, or all words
     * are lost.
     *
     * @param ears range of the hearer [m]
     * @param distance distance of the hearer [m]
     */
    Optional<Arrived> at(ItemId hearer, double ears, double distance) {
        if (distance > Math.min(voice.range(), ears)) {
            return Optional.empty();
        }
        double clarity = voice.clarity(distance);
        if (clarity == 1) {
            return Optional.of(whole());
        }
        List<String> parts = words(text);
        long state = seed(hearer);
        int lost = 0;
        for (int word = 1; word < parts.size(); word += 2) {
            state += STEP;
            if ((mixed(state) >>> 11) * 0x1p-53 >= clarity) {
                parts.set(word, LOST);
                lost++;
            }
        }
        return lost == words
                ? Optional.empty()
                : Optional.of(new Arrived(String.join("", parts), lost));
    }

    /** Returns the text without losses. */
    Arrived whole() {
        return new Arrived(text, 0);
    }

    /**
     * Returns the event for a hearer.
     *
     * @param name name of the speaker's body, if the hearer's sensors sense it
     * @param at location of the hearer (3) [m]
     */
    ServerMessage.Event event(Arrived arrived, Optional<String> name, double[] at) {
        double distance = distance(at);
        var direction = new ArrayList<Double>(3);
        for (int axis = 0; axis < 3; axis++) {
            direction.add(distance > 0 ? (from[axis] - at[axis]) / distance : 0.0);
        }
        var fields = new LinkedHashMap<String, Object>();
        fields.put(TEXT, arrived.text);
        if (arrived.lost > 0) {
            fields.put("lost", arrived.lost);
        }
        name.ifPresent(speaks -> fields.put("speaker", speaks));
        fields.put("direction", direction);
        fields.put("distance", distance);
        return new ServerMessage.Event(frame, "heard", fields);
    }

    private long seed(ItemId hearer) {
        long seed = mixed(frame);
        seed = mixed(seed + STEP * speaker.value());
        seed = mixed(seed + STEP * hearer.value());
        return mixed(mixed(seed, world), text);
    }

    private static long mixed(long seed, String characters) {
        long mixed = mixed(seed + characters.length());
        for (int i = 0; i < characters.length(); i++) {
            mixed = mixed(mixed + STEP * characters.charAt(i));
        }
        return mixed;
    }

    private static long mixed(long bits) {
        long z = (bits ^ bits >>> 30) * 0xbf58476d1ce4e5b9L;
        z = (z ^ z >>> 27) * 0x94d049bb133111ebL;
        return z ^ z >>> 31;
    }

    /**
     * Splits a text into blanks and words, in turn: the elements with an odd index are the words.
     * The concatenation of the elements is the text.
     */
    private static List<String> words(String text) {
        var parts = new ArrayList<String>();
        int start = 0;
        boolean blank = true;
        for (int i = 0; i < text.length(); i++) {
            if (Character.isWhitespace(text.charAt(i)) != blank) {
                parts.add(text.substring(start, i));
                start = i;
                blank = !blank;
            }
        }
        parts.add(text.substring(start));
        return parts;
    }
}
