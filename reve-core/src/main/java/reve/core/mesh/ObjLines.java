package reve.core.mesh;

import java.nio.charset.StandardCharsets;
import java.util.Map;
import java.util.Optional;
import java.util.regex.Pattern;

/** Finds the line of an OBJ file that its reader stumbled over. */
final class ObjLines {
    private static final Pattern NUMBER =
            Pattern.compile("[+-]?(\\d+\\.?\\d*|\\.\\d+)([eE][+-]?\\d+)?");
    private static final Pattern CORNER = Pattern.compile("-?\\d{1,9}(/(-?\\d{1,9})?){0,2}");
    /** Fewest numbers behind a keyword. */
    private static final Map<String, Integer> NUMBERS = Map.of("v", 3, "vt", 1, "vn", 3);
    private static final int CORNERS = 3;
    private static final int SHOWN = 48;

    private ObjLines() {}

    /** The first line that is wrong in itself, and what is expected of it. */
    static Optional<String> fault(byte[] bytes) {
        int number = 0;
        for (String line : new String(bytes, StandardCharsets.ISO_8859_1).split("\\R")) {
            number++;
            String[] words = line.strip().split("\\s+");
            Optional<String> expected = expected(words);
            if (expected.isPresent()) {
                return Optional.of("line " + number + " is `" + shorten(line.strip())
                        + "`, expected " + expected.get());
            }
        }
        return Optional.empty();
    }

    /** What a line should be; empty if it is that. */
    private static Optional<String> expected(String[] words) {
        int least = words[0].equals("f") ? CORNERS : NUMBERS.getOrDefault(words[0], 0);
        Pattern pattern = words[0].equals("f") ? CORNER : NUMBER;
        boolean right = least == 0 || words.length > least;
        for (int i = 1; right && least > 0 && i <= (words[0].equals("f") ? words.length - 1
                : least); i++) {
            right = pattern.matcher(words[i]).matches();
        }
        return right ? Optional.empty() : Optional.of(words[0].equals("f")
                ? "at least three corners such as `f 1 2 3` or `f 1/1/1 2/2/1 3/3/1`"
                : "`" + words[0] + "` and at least " + least
                        + (least == 1 ? " number" : " numbers"));
    }

    private static String shorten(String text) {
        return text.length() <= SHOWN ? text : text.substring(0, SHOWN - 1) + "…";
    }
}
