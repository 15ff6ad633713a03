// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;

/**
 * The computing time that the laws of a library may take in a frame, and the response if they take
 * more.
 *
 * @param nanoseconds maximum time of all laws of the library together in one frame [ns], above 0
 * @param frames number of successive frames that must exceed the time before the response
 * @param every number n, at least 2: the response {@link Response#SKIP_STEPS} evaluates the laws in
 *     every n-th step only
 */
public record TimeBudget(long nanoseconds, int frames, Response response, int every) {
    /** Default of {@code frames}. */
    public static final int DEFAULT_FRAMES = 10;

    /** Default of {@code every}. */
    public static final int DEFAULT_EVERY = 2;

    /** Maximum of {@code frames}. */
    public static final int MOST_FRAMES = 10_000;

    /** Maximum of {@code every}. */
    public static final int MOST_EVERY = 1_000;

    /** Maximum time in one frame [s]. */
    public static final double MOST_SECONDS = 10;

    private static final double NANOSECONDS = 1e9;

    /** The response to a library that exceeds its budget. */
    public enum Response {
        /** Response in which an event reports the library. */
        WARN,
        /** Response in which the library is unloaded. */
        UNLOAD,
        /**
         * Response in which the force laws of the library are evaluated only in every n-th step.
         */
        SKIP_STEPS;

        /** Finds the response whose {@link #text} is given. */
        public static Optional<Response> find(String text) {
            return Arrays.stream(values()).filter(one -> one.text().equals(text)).findFirst();
        }

        /** Returns the name of this response in world files and messages, such as "skip-steps". */
        public String text() {
            return name().toLowerCase(Locale.ROOT).replace('_', '-');
        }
    }

    /** Checks that the numbers are in their ranges. */
    public TimeBudget {
        if (nanoseconds < 1 || nanoseconds > MOST_SECONDS * NANOSECONDS) {
            throw new IllegalArgumentException(
                    "a budget of " + nanoseconds + " ns, expected 1 ns to " + MOST_SECONDS + " s");
        }
        requireRange("frames", frames, 1, MOST_FRAMES);
        requireRange("every", every, 2, MOST_EVERY);
    }

    /** Returns a budget whose time is given in seconds [s]. */
    public static TimeBudget of(double seconds, int frames, Response response, int every) {
        return new TimeBudget(
                Math.max(1, Math.round(seconds * NANOSECONDS)), frames, response, every);
    }

    private static void requireRange(String name, int found, int least, int most) {
        if (found < least || found > most) {
            throw new IllegalArgumentException(
                    name + " is " + found + ", expected " + least + " to " + most);
        }
    }

    /** Returns the maximum time in one frame [ms]. */
    public double milliseconds() {
        return nanoseconds / 1e6;
    }

    /** Returns the fields of the budget in the form of the message {@code set-budget}, for JSON. */
    public Map<String, Object> fields() {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("milliseconds", milliseconds());
        fields.put("frames", frames);
        fields.put("then", response.text());
        if (response == Response.SKIP_STEPS) {
            fields.put("every", every);
        }
        return fields;
    }
}
