// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import com.ibm.icu.text.SpoofChecker;

import java.lang.Character.UnicodeScript;
import java.nio.charset.CharsetEncoder;
import java.nio.charset.StandardCharsets;
import java.text.Normalizer;
import java.util.Collection;
import java.util.EnumSet;
import java.util.HashMap;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/**
 * Warnings about names that look alike. Such names have equal skeletons. A skeleton is a simplified
 * form of a name, as defined by Unicode Technical Standard 39. Names of ASCII characters are
 * compared directly. The library ICU is loaded only for a world with other characters.
 */
final class LookAlikes {
    private static final Pattern WORD = Pattern.compile("[\\p{L}\\p{M}]+");

    private final Problems problems;
    private final CharsetEncoder ascii = StandardCharsets.US_ASCII.newEncoder();
    private final SpoofChecker checker =
            new SpoofChecker.Builder().setChecks(SpoofChecker.CONFUSABLE).build();

    private final Set<String> warned = new HashSet<>();

    private LookAlikes(Problems problems) {
        this.problems = problems;
    }

    /**
     * Records a warning for each name that looks like another one.
     *
     * @param names texts, all different, in the order of the file
     */
    static void warn(Collection<Node> names, Problems problems) {
        CharsetEncoder ascii = StandardCharsets.US_ASCII.newEncoder();
        List<Node> others = names.stream().filter(name -> !ascii.canEncode(text(name))).toList();
        if (!others.isEmpty()) {
            new LookAlikes(problems).warn(names, others);
        }
    }

    private void warn(Collection<Node> names, List<Node> others) {
        Map<String, Node> bySkeleton = new HashMap<>();
        boolean likeAscii = false;
        for (Node name : others) {
            String skeleton = skeleton(name);
            likeAscii |= ascii.canEncode(skeleton);
            Node first = bySkeleton.putIfAbsent(skeleton, name);
            if (first != null) {
                warn(name, first);
            }
        }
        if (likeAscii) {
            for (Node name : names) {
                Node other = ascii.canEncode(text(name)) ? bySkeleton.get(skeleton(name)) : null;
                if (other != null) {
                    warn(other, name);
                }
            }
        }
        others.stream()
                .filter(name -> !warned.contains(text(name)))
                .forEach(this::warnOfMixedWords);
    }

    /**
     * Returns the skeleton of the name's Unicode compatibility form. This form replaces full-width
     * letters by ordinary ones.
     */
    private String skeleton(Node name) {
        return checker.getSkeleton(Normalizer.normalize(text(name), Normalizer.Form.NFKC));
    }

    private void warn(Node name, Node other) {
        warned.add(text(name));
        problems.warn(
                name,
                "name: `"
                        + Node.shorten(text(name))
                        + "` looks like `"
                        + Node.shorten(text(other))
                        + "` "
                        + Problems.place(other, name)
                        + ", but has other characters; write them alike or choose another name");
    }

    /** Warns of a word that looks like ASCII letters but contains letters of several scripts. */
    private void warnOfMixedWords(Node name) {
        Matcher word = WORD.matcher(text(name));
        while (word.find()) {
            if (scripts(word.group()).size() > 1) {
                String skeleton = checker.getSkeleton(word.group());
                if (ascii.canEncode(skeleton)) {
                    problems.warn(
                            name,
                            "name: `"
                                    + Node.shorten(word.group())
                                    + "` looks like `"
                                    + Node.shorten(skeleton)
                                    + "`, but mixes letters of "
                                    + "several scripts; write it in one");
                }
            }
        }
    }

    private static Set<UnicodeScript> scripts(String word) {
        Set<UnicodeScript> scripts = EnumSet.noneOf(UnicodeScript.class);
        word.codePoints().mapToObj(UnicodeScript::of).forEach(scripts::add);
        scripts.removeAll(EnumSet.of(UnicodeScript.COMMON, UnicodeScript.INHERITED));
        return scripts;
    }

    private static String text(Node name) {
        return name.text().orElseThrow();
    }
}
