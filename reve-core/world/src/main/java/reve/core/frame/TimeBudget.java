// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;

/**
 * The computing time that a library of laws may take in a frame, and what happens if it takes more.
 *
 * @param nanoseconds that its laws together may take in a frame [ns], above 0
 * @param frames number of frames in a row that must be too long before anything happens
 * @param every with {@link Response#SKIP_STEPS}, the laws are evaluated in every n-th step, at
 *     least 2
 */
public record TimeBudget(long nanoseconds, int frames, Response response, int every) {
    /** Number of frames in a row, unless the operator gives another one. */
    public static final int DEFAULT_FRAMES = 10;

    /** The steps of {@link Response#SKIP_STEPS}, unless the operator gives another number. */
    public static final int DEFAULT_EVERY = 2;

    /** Maximum of {@code frames}. */
    public static final int MOST_FRAMES = 10_000;

    /** Maximum of {@code every}. */
    public static final int MOST_EVERY = 1_000;

    /** Maximum time [s]. */
    public static final double MOST_SECONDS = 10;

    private static final double NANOSECONDS = 1e9;

    /** What happens to a library that exceeds its budget. */
    public enum Response {
        /** An event reports it. */
        WARN,
        /** The library is unloaded. */
        UNLOAD,
        /** Its force laws are evaluated in every n-th step only. */
        SKIP_STEPS;

        /** Returns the response with this name. */
        public static Optional<Response> find(String text) {
            return Arrays.stream(values()).filter(one -> one.text().equals(text)).findFirst();
        }

        /** Returns the name in world files and messages, such as "skip-steps". */
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

    /** Returns the budget of a time [s]. */
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

    /** Returns the time [ms]. */
    public double milliseconds() {
        return nanoseconds / 1e6;
    }

    /** Returns the fields for JSON, as the message {@code set-budget} has them. */
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
