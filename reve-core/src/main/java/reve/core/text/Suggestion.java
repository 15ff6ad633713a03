package reve.core.text;

import java.util.Collection;
import java.util.Comparator;
import java.util.Locale;

/** Finds the name that was probably meant. */
public final class Suggestion {
    /** Names beyond these are not looked at, so that a wrong file is refused quickly. */
    private static final int MAX_CANDIDATES = 1_000;

    private Suggestion() {}

    /** {@code "; did you mean `x`?"}, or nothing if no known name is near. */
    public static String of(String wrong, Collection<String> known) {
        int limit = Math.max(1, wrong.length() / 3);
        record Candidate(String name, int distance) {}
        return known.stream().limit(MAX_CANDIDATES)
                .filter(name -> Math.abs(name.length() - wrong.length()) <= limit)
                .map(name -> new Candidate(name, distance(lower(wrong), lower(name))))
                .filter(candidate -> candidate.distance <= limit
                        && candidate.distance < Math.min(wrong.length(), candidate.name.length()))
                .min(Comparator.comparingInt(Candidate::distance))
                .map(candidate -> "; did you mean `" + candidate.name + "`?").orElse("");
    }

    private static String lower(String text) {
        return text.toLowerCase(Locale.ROOT);
    }

    /** Fewest insertions, deletions, replacements and swaps of neighbours between two texts. */
    private static int distance(String a, String b) {
        int[][] d = new int[a.length() + 1][b.length() + 1];
        for (int i = 0; i <= a.length(); i++) {
            for (int j = 0; j <= b.length(); j++) {
                if (i == 0 || j == 0) {
                    d[i][j] = i + j;
                    continue;
                }
                boolean same = a.charAt(i - 1) == b.charAt(j - 1);
                d[i][j] = Math.min(d[i - 1][j - 1] + (same ? 0 : 1),
                        Math.min(d[i - 1][j], d[i][j - 1]) + 1);
                if (i > 1 && j > 1 && a.charAt(i - 1) == b.charAt(j - 2)
                        && a.charAt(i - 2) == b.charAt(j - 1)) {
                    d[i][j] = Math.min(d[i][j], d[i - 2][j - 2] + 1);
                }
            }
        }
        return d[a.length()][b.length()];
    }
}
