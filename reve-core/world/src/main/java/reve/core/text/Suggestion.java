// SPDX-License-Identifier: Apache-2.0
package reve.core.text;

import java.util.Arrays;
import java.util.Collection;
import java.util.Comparator;
import java.util.Locale;
import java.util.Optional;

/** Search for the known name that a misspelt name probably means. */
public final class Suggestion {
    /**
     * Maximum number of names that are compared. The limit bounds the time to refuse a faulty file.
     */
    private static final int MAX_CANDIDATES = 1_000;

    /**
     * Maximum length of a misspelt text for which a name is searched [characters]. Names of items
     * are not longer.
     */
    private static final int MAX_LENGTH = 128;

    /** Maximum edit distance between the text and a suggested name. */
    private static final int MAX_DISTANCE = 8;

    private Suggestion() {}

    /**
     * Returns the last part of a message, {@code "; did you mean `x`?"}. Returns an empty text if
     * no known name is similar.
     */
    public static String of(String wrong, Collection<String> known) {
        return nearest(wrong, known).map(name -> "; did you mean `" + name + "`?").orElse("");
    }

    /** Returns the known name that is most similar; empty if no known name is similar. */
    public static Optional<String> nearest(String wrong, Collection<String> known) {
        if (wrong.length() > MAX_LENGTH) {
            return Optional.empty();
        }
        int limit = Math.clamp(wrong.length() / 3, 1, MAX_DISTANCE);
        String written = lower(wrong);
        record Candidate(String name, int distance) {}
        return known.stream()
                .limit(MAX_CANDIDATES)
                .filter(name -> Math.abs(name.length() - wrong.length()) <= limit)
                .map(name -> new Candidate(name, distance(written, lower(name), limit)))
                .filter(
                        candidate ->
                                candidate.distance <= limit
                                        && candidate.distance
                                                < Math.min(wrong.length(), candidate.name.length()))
                .min(Comparator.comparingInt(Candidate::distance))
                .map(Candidate::name);
    }

    private static String lower(String text) {
        return text.toLowerCase(Locale.ROOT);
    }

    /**
     * Returns the minimum number of insertions, deletions, replacements and swaps of neighbours
     * that turn one text into the other. Returns any number above the limit if this number exceeds
     * {@code limit}.
     *
     * <p>Uses dynamic programming, but stores only the last three rows of the table and computes
     * only the cells near the diagonal.
     */
    private static int distance(String a, String b, int limit) {
        int far = limit + 1;
        int[] twoAbove = new int[b.length() + 1];
        int[] above = new int[b.length() + 1];
        int[] row = new int[b.length() + 1];
        Arrays.setAll(row, j -> Math.min(j, far));
        for (int i = 1; i <= a.length(); i++) {
            int[] oldest = twoAbove;
            twoAbove = above;
            above = row;
            row = oldest;
            Arrays.fill(row, far);
            row[0] = Math.min(i, far);
            int least = row[0];
            for (int j = Math.max(1, i - limit); j <= Math.min(b.length(), i + limit); j++) {
                boolean same = a.charAt(i - 1) == b.charAt(j - 1);
                int distance =
                        Math.min(above[j - 1] + (same ? 0 : 1), Math.min(above[j], row[j - 1]) + 1);
                if (i > 1
                        && j > 1
                        && a.charAt(i - 1) == b.charAt(j - 2)
                        && a.charAt(i - 2) == b.charAt(j - 1)) {
                    distance = Math.min(distance, twoAbove[j - 2] + 1);
                }
                row[j] = distance;
                least = Math.min(least, distance);
            }
            if (least > limit) {
                return far;
            }
        }
        return row[b.length()];
    }
}
