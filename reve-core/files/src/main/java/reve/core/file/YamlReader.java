// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import org.jspecify.annotations.Nullable;
import org.snakeyaml.engine.v2.api.LoadSettings;
import org.snakeyaml.engine.v2.api.lowlevel.Parse;
import org.snakeyaml.engine.v2.events.AliasEvent;
import org.snakeyaml.engine.v2.events.CollectionEndEvent;
import org.snakeyaml.engine.v2.events.CollectionStartEvent;
import org.snakeyaml.engine.v2.events.DocumentStartEvent;
import org.snakeyaml.engine.v2.events.Event;
import org.snakeyaml.engine.v2.events.MappingStartEvent;
import org.snakeyaml.engine.v2.events.NodeEvent;
import org.snakeyaml.engine.v2.events.ScalarEvent;
import org.snakeyaml.engine.v2.exceptions.Mark;
import org.snakeyaml.engine.v2.exceptions.MarkedYamlEngineException;
import org.snakeyaml.engine.v2.exceptions.ReaderException;
import org.snakeyaml.engine.v2.exceptions.YamlEngineException;
import org.snakeyaml.engine.v2.exceptions.YamlVersionException;
import org.snakeyaml.engine.v2.nodes.Tag;
import org.snakeyaml.engine.v2.resolver.CoreScalarResolver;
import org.snakeyaml.engine.v2.resolver.ScalarResolver;

import java.io.IOException;
import java.io.StringReader;
import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Deque;
import java.util.Iterator;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;

/**
 * Parser of a text into {@link Node}s. The text is one YAML 1.2 document of mappings, lists and
 * scalars. The parser refuses surprising or dangerous features of YAML: aliases, tags, several
 * documents, deep nesting.
 */
final class YamlReader {
    /** Maximum nesting depth of mappings and lists. */
    static final int MAX_DEPTH = 32;

    /**
     * Maximum number of values in a file and its included files. Mappings and lists count as
     * values.
     */
    static final int MAX_VALUES = 2_000_000;

    /**
     * Maximum number of values outside the key {@code items}. It is lower than {@link #MAX_VALUES},
     * so that a huge file without items is refused early.
     */
    static final int MAX_OTHER_VALUES = 500_000;

    /** Maximum number of keys of one mapping. */
    static final int MAX_KEYS = 65_536;

    /** Maximum length of a key or a value [characters]. */
    static final int MAX_TEXT_LENGTH = 65_536;

    /**
     * Maximum size of the YAML library's buffer [characters]. The library copies the unread rest of
     * the buffer for each refill. The time would grow with the square of a token's length if the
     * small default buffer were used.
     */
    private static final int MAX_PIECE = 1 << 20;

    private static final int MIN_PIECE = 1024;

    /**
     * Maximum length of each half of a message of the YAML library [characters]. The limit exists
     * because the message may quote the file.
     */
    private static final int MAX_QUOTE = 200;

    /**
     * Explanations of indicators that this reader refuses at the start of a value. The keys are the
     * words of the YAML library for these indicators.
     */
    private static final Map<String, String> SIGNS =
            Map.of(
                    " tag",
                    "`!` begins a tag",
                    " anchor",
                    "`&` begins an anchor",
                    " alias",
                    "`*` begins an alias",
                    " directive",
                    "`%` begins a directive");

    private final String text;
    private final boolean kept;
    private final Problems problems;
    private final Allowance values;
    private final ScalarResolver resolver = new CoreScalarResolver(false);

    /** The mappings and lists that are open. The innermost one is the last. */
    private final Deque<Node> open = new ArrayDeque<>();

    private @Nullable Node root;

    /** The key or list element whose value is read next. */
    private Node.@Nullable Slot waiting;

    /** Position at which the last event of the YAML library begins. */
    private Optional<Mark> taken = Optional.empty();

    private int documents;
    private boolean inItems;
    private int others;

    /**
     * Position of the last call of {@link #offset} in code points. The next field contains the same
     * position in characters.
     */
    private int passedPoints;

    private int passed;

    private YamlReader(String text, boolean kept, Problems problems, Allowance values) {
        this.text = text;
        this.kept = kept;
        this.problems = problems;
        this.values = values;
    }

    /**
     * Returns the outermost mapping of the text. Duplicate keys and non-finite numbers are added to
     * {@code problems} and do not end the reading.
     *
     * @param values number of values that may still be read
     * @throws WorldFileException if reading cannot continue, because of the syntax, a limit or a
     *     refused feature of YAML
     */
    static Node read(String text, Problems problems, Allowance values) throws WorldFileException {
        return read(text, problems, values, false);
    }

    private static Node read(String text, Problems problems, Allowance values, boolean kept)
            throws WorldFileException {
        var settings =
                LoadSettings.builder()
                        .setCodePointLimit(Integer.MAX_VALUE)
                        .setBufferSize(Math.clamp(text.length() + 2L, MIN_PIECE, MAX_PIECE))
                        .build();
        var reader = new YamlReader(text, kept, problems, values);
        try {
            Iterator<Event> events =
                    new Parse(settings).parseReader(new WholeCharacters(text)).iterator();
            while (events.hasNext()) {
                reader.take(events.next());
            }
        } catch (NumberFormatException escape) {
            throw reader.fatal(reader.noCharacter(reader.taken));
        } catch (MarkedYamlEngineException syntax) {
            throw reader.notYaml(syntax);
        } catch (ReaderException unprintable) {
            throw fatalAt(text, unprintable, problems);
        } catch (YamlVersionException version) {
            throw problems.fatal(1, 1, "written for another YAML version; remove the line `%YAML`");
        } catch (YamlEngineException other) {
            throw problems.fatal(1, 1, "not valid YAML: " + other.getMessage());
        }
        return reader.requireRoot();
    }

    /** Reads the text of a store file like {@link #read}, but accepts unpaired surrogates. */
    static Node readKept(String text, Problems problems) throws WorldFileException {
        return read(text, problems, new Allowance(MAX_VALUES), true);
    }

    /**
     * A reader that leaves one character of the buffer free for the YAML library. The library
     * appends the second half if the buffer ends between the halves of a surrogate pair.
     */
    private static final class WholeCharacters extends StringReader {
        WholeCharacters(String text) {
            super(text);
        }

        @Override
        public int read(char[] buffer) throws IOException {
            return read(buffer, 0, buffer.length - 1);
        }
    }

    private void take(Event event) throws WorldFileException {
        taken = event.getStartMark();
        switch (event) {
            case DocumentStartEvent start -> {
                if (++documents > 1) {
                    throw fatal(
                            start.getStartMark(),
                            "a second document begins here; a file holds one world");
                }
            }
            case AliasEvent alias ->
                    throw fatal(
                            alias.getStartMark(),
                            "aliases (`"
                                    + Node.shorten("*" + alias.getAlias())
                                    + "`) are not allowed; write the value out");
            case CollectionStartEvent start -> {
                refuseFeatures(start, start.getTag());
                openCollection(start);
            }
            case ScalarEvent scalar -> {
                refuseFeatures(scalar, scalar.getTag());
                takeScalar(scalar);
            }
            case CollectionEndEvent end -> open.removeLast();
            // The other events have no content. They mark, for example, the start and end of the
            // document.
            default -> {}
        }
    }

    private void refuseFeatures(NodeEvent event, Optional<String> tag) throws WorldFileException {
        if (event.getAnchor().isPresent()) {
            throw fatal(
                    event.getStartMark(),
                    "anchors (`"
                            + Node.shorten("&" + event.getAnchor().get())
                            + "`) are not allowed; write values out where they are used");
        }
        if (tag.isPresent()) {
            throw fatal(
                    event.getStartMark(),
                    "tags (`"
                            + Node.shorten(tag.get())
                            + "`) are not allowed; write the value only");
        }
    }

    private void openCollection(CollectionStartEvent start) throws WorldFileException {
        if (awaitsKey()) {
            throw fatal(start.getStartMark(), "a key must be a name, found a list or a mapping");
        }
        if (open.size() == MAX_DEPTH) {
            throw fatal(start.getStartMark(), "nested deeper than " + MAX_DEPTH + " levels");
        }
        boolean mapping = start instanceof MappingStartEvent;
        open.addLast(
                place(start, mapping ? new LinkedHashMap<String, Node>() : new ArrayList<Node>()));
    }

    private void takeScalar(ScalarEvent scalar) throws WorldFileException {
        String text = scalar.getValue();
        if (text.length() > MAX_TEXT_LENGTH) {
            throw fatal(
                    scalar.getStartMark(),
                    "a text of "
                            + text.length()
                            + " characters; at most "
                            + MAX_TEXT_LENGTH
                            + " are allowed");
        }
        if (!kept && !problems.full() && Escapes.hasHalf(text)) {
            Problem half = noCharacter(scalar.getStartMark());
            problems.add(half.line(), half.column(), pointerOfNext(), half.message());
        }
        if (awaitsKey()) {
            Mark mark = scalar.getStartMark().orElseThrow();
            if (open.getLast().children().size() == MAX_KEYS) {
                throw fatal(scalar.getStartMark(), "a mapping of more than " + MAX_KEYS + " keys");
            }
            open.getLast()
                    .get(text)
                    .ifPresent(
                            first ->
                                    problems.add(
                                            mark.getLine() + 1,
                                            mark.getColumn() + 1,
                                            first.pointer(),
                                            "duplicate key `"
                                                    + Node.shorten(text)
                                                    + "`, first on line "
                                                    + first.keyLine()));
            waiting = new Node.Slot(open.getLast(), text, mark.getLine() + 1, mark.getColumn() + 1);
        } else {
            Node node = place(scalar, scalar.isPlain() ? resolve(scalar) : text);
            if (!scalar.isPlain()) {
                boolean quoted = scalar.isSQuoted() || scalar.isDQuoted();
                node.setTextColumn(quoted ? node.column() + 1 : -1);
            }
        }
    }

    /**
     * Returns the value of an unquoted scalar by YAML's core schema: a number, a boolean, null, or
     * text.
     */
    private @Nullable Object resolve(ScalarEvent scalar) {
        String text = scalar.getValue();
        Tag tag = resolver.resolve(text, true);
        if (tag.equals(Tag.NULL)) {
            return null;
        }
        if (tag.equals(Tag.BOOL)) {
            return text.equalsIgnoreCase("true");
        }
        if (tag.equals(Tag.INT)) {
            return integer(text);
        }
        return tag.equals(Tag.FLOAT) ? real(scalar) : text;
    }

    private static Object integer(String text) {
        try {
            if (text.startsWith("0x")) {
                return Long.parseLong(text.substring(2), 16);
            }
            if (text.startsWith("0o")) {
                return Long.parseLong(text.substring(2), 8);
            }
            return Long.parseLong(text);
        } catch (NumberFormatException beyond64Bit) {
            return text.startsWith("0x") || text.startsWith("0o")
                    ? text
                    : (Object) Double.valueOf(text);
        }
    }

    private Object real(ScalarEvent scalar) {
        String text = scalar.getValue();
        boolean digits = text.chars().anyMatch(Character::isDigit);
        double value = digits ? Double.parseDouble(text) : Double.NaN;
        if (Double.isFinite(value)) {
            return value;
        }
        Mark mark = scalar.getStartMark().orElseThrow();
        problems.add(
                mark.getLine() + 1,
                mark.getColumn() + 1,
                pointerOfNext(),
                subjectOfNext()
                        + (digits
                                ? "`" + Node.shorten(text) + "` is too large for a 64-bit number"
                                : "`" + text + "` is not a finite number"));
        return 1.0; // a placeholder, so that the rest of the file is still checked
    }

    private String subjectOfNext() {
        return waiting == null ? "" : waiting.key() + ": ";
    }

    private String pointerOfNext() {
        if (waiting != null) {
            return waiting.parent().pointer() + "/" + waiting.key();
        }
        return open.isEmpty()
                ? ""
                : open.getLast().pointer() + "/" + open.getLast().children().size();
    }

    private boolean awaitsKey() {
        return waiting == null && !open.isEmpty() && open.getLast().isMapping();
    }

    private Node place(Event event, @Nullable Object value) throws WorldFileException {
        Mark mark = event.getStartMark().orElseThrow();
        int line = mark.getLine() + 1;
        int column = mark.getColumn() + 1;
        if (open.size() == 1 && waiting != null) {
            inItems = waiting.key().equals("items");
        }
        if (!inItems && ++others > MAX_OTHER_VALUES) {
            throw problems.fatal(
                    line, column, "more than " + MAX_OTHER_VALUES + " values outside of `items`");
        }
        if (!values.take(1)) {
            throw problems.fatal(line, column, "more than " + MAX_VALUES + " values in all");
        }
        Node node;
        if (open.isEmpty()) {
            node = Node.root(problems.file(), line, column, value);
            root = node;
        } else {
            Node parent = open.getLast();
            Node.Slot slot =
                    waiting != null
                            ? waiting
                            : new Node.Slot(parent, parent.children().size(), line, column);
            waiting = null;
            node = slot.fill(line, column, value);
        }
        return node;
    }

    private Node requireRoot() throws WorldFileException {
        if (root == null || root.isNothing()) {
            throw problems.fatal(
                    1, 1, "the file is empty; a world begins with `reve: 1` and a " + "`name`");
        }
        if (!root.isMapping()) {
            throw problems.fatal(
                    root.line(),
                    root.column(),
                    "found "
                            + root.describe()
                            + ", expected a mapping that begins with `reve: 1` and a `name`");
        }
        return root;
    }

    private WorldFileException fatal(Optional<Mark> mark, String message) {
        return problems.fatal(
                mark.map(Mark::getLine).orElse(0) + 1,
                mark.map(Mark::getColumn).orElse(0) + 1,
                message);
    }

    /** Returns the problem of the first invalid escape at or after a position. */
    private Problem noCharacter(Optional<Mark> from) {
        int begin = offset(from);
        Optional<Escapes.Wrong> wrong = Escapes.find(text, begin);
        int at = wrong.map(Escapes.Wrong::offset).orElse(begin);
        return new Problem(
                Problem.Severity.ERROR,
                problems.file(),
                1
                        + from.map(Mark::getLine).orElse(0)
                        + (int) text.substring(begin, at).chars().filter(c -> c == '\n').count(),
                at - text.lastIndexOf('\n', at - 1),
                "",
                wrong.map(Escapes.Wrong::message)
                        .orElse(
                                "not valid YAML: an escape in double "
                                        + "quotes, such as `\\u00e9`, stands for no character"));
    }

    private WorldFileException fatal(Problem problem) {
        return problems.fatal(problem.line(), problem.column(), problem.message());
    }

    /**
     * Converts a position of the YAML library from code points into characters. Counts from the
     * last position, because each position is at or after the last one.
     */
    private int offset(Optional<Mark> mark) {
        int points = mark.map(Mark::getIndex).orElse(0);
        if (points < passedPoints) {
            passedPoints = 0;
            passed = 0;
        }
        while (passedPoints < points && passed < text.length()) {
            passed += Character.charCount(text.codePointAt(passed));
            passedPoints++;
        }
        return passed;
    }

    /**
     * Returns an exception for a syntax error. The exception names a quote or bracket that is not
     * closed.
     */
    private WorldFileException notYaml(MarkedYamlEngineException syntax) {
        int line = syntax.getProblemMark().map(Mark::getLine).orElse(0) + 1;
        int column = syntax.getProblemMark().map(Mark::getColumn).orElse(0) + 1;
        if (syntax.getProblem().startsWith("found unknown escape character")
                && Escapes.find(text, offset(syntax.getContextMark())).isPresent()) {
            return fatal(noCharacter(syntax.getContextMark()));
        }
        Optional<Unclosed.Opening> opening = Unclosed.find(text, line, column);
        if (opening.isEmpty()) {
            return problems.fatal(line, column, sentence(syntax));
        }
        Unclosed.Opening open = opening.get();
        boolean comment = text.lines().skip(open.line() - 1L).findFirst().orElse("").contains(" #");
        return problems.fatal(
                open.line(),
                open.column(),
                "`"
                        + open.sign()
                        + "` is not closed, "
                        + "which was noticed on line "
                        + line
                        + (comment ? "; a # begins a comment unless it is in quotes" : ""));
    }

    /** Joins the two halves of the library's message. Omits its excerpt of the line. */
    private static String sentence(MarkedYamlEngineException syntax) {
        String context = syntax.getContext();
        String problem =
                shorten(syntax.getProblem())
                        .replaceAll(
                                " ?\\(Do not use [^\\\\].* for " + "indentation\\)",
                                " Put the text in quotes")
                        .replaceAll("(?s)\\s\\((?:10|13)\\)|\\x00\\(0\\)", "the end of the line")
                        .replaceAll("(\\S)\\(\\d+\\)", "`$1`");
        String what = context == null ? "" : shorten(context);
        for (Map.Entry<String, String> sign : SIGNS.entrySet()) {
            if (what.endsWith(sign.getKey())) {
                return "not valid YAML: a "
                        + sign.getValue()
                        + ", which is not allowed; put a "
                        + "text that begins with it in quotes";
            }
        }
        if (what.endsWith("double-quoted scalar") && problem.contains("escape")) {
            return "not valid YAML: `\\` in double quotes begins an escape such as `\\n` or "
                    + "`\\u00e9`; write it twice, or put the text in single quotes";
        }
        if (problem.contains("mapping keys are not allowed")) {
            return "not valid YAML: `?` begins no key here; put a text that begins with it in "
                    + "quotes";
        }
        if (problem.contains("sequence entries are not allowed")) {
            return "not valid YAML: `-` begins no element here; elements of a list begin on lines "
                    + "of their own";
        }
        if (problem.startsWith("mapping values are not allowed")) {
            return "not valid YAML: a `:` makes no key here; put a text that holds `: ` in quotes, "
                    + "and begin all keys of a mapping in one column";
        }
        if (problem.startsWith("expected <block end>")) {
            return "not valid YAML: this is neither a key nor an element of what stands above; "
                    + "look at the indentation, and at quotes within quotes";
        }
        return "not valid YAML: " + (what.isEmpty() ? problem : what + ", " + problem);
    }

    private static String shorten(String message) {
        return message.length() <= MAX_QUOTE ? message : message.substring(0, MAX_QUOTE) + "…";
    }

    private static WorldFileException fatalAt(
            String text, ReaderException unprintable, Problems problems) {
        int position = text.indexOf(unprintable.getCodePoint());
        String before = text.substring(0, Math.max(position, 0));
        int line = 1 + (int) before.chars().filter(c -> c == '\n').count();
        return problems.fatal(
                line,
                before.length() - before.lastIndexOf('\n'),
                String.format(
                        "the character U+%04X is not allowed in a world file",
                        unprintable.getCodePoint()));
    }
}
