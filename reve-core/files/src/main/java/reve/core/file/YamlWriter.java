// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import org.snakeyaml.engine.v2.api.DumpSettings;
import org.snakeyaml.engine.v2.api.StreamDataWriter;
import org.snakeyaml.engine.v2.common.FlowStyle;
import org.snakeyaml.engine.v2.common.ScalarStyle;
import org.snakeyaml.engine.v2.emitter.Emitter;
import org.snakeyaml.engine.v2.events.DocumentEndEvent;
import org.snakeyaml.engine.v2.events.DocumentStartEvent;
import org.snakeyaml.engine.v2.events.ImplicitTuple;
import org.snakeyaml.engine.v2.events.MappingEndEvent;
import org.snakeyaml.engine.v2.events.MappingStartEvent;
import org.snakeyaml.engine.v2.events.ScalarEvent;
import org.snakeyaml.engine.v2.events.SequenceEndEvent;
import org.snakeyaml.engine.v2.events.SequenceStartEvent;
import org.snakeyaml.engine.v2.events.StreamEndEvent;
import org.snakeyaml.engine.v2.events.StreamStartEvent;
import org.snakeyaml.engine.v2.nodes.Tag;
import org.snakeyaml.engine.v2.resolver.CoreScalarResolver;
import org.snakeyaml.engine.v2.resolver.ScalarResolver;

import java.util.Collection;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Writer of mappings, lists, texts, numbers and booleans as YAML. {@link YamlReader} reads this
 * YAML back to the bit. The same values always give the same text. A value that contains a mapping
 * takes several lines, and any other value one line.
 */
public final class YamlWriter {
    private static final int WIDTH = 100;
    private static final double LARGEST_WRITTEN_AS_INTEGER = 1e15;
    private static final DumpSettings SETTINGS =
            DumpSettings.builder()
                    .setWidth(WIDTH)
                    .setIndicatorIndent(2)
                    .setIndentWithIndicator(true)
                    .build();
    private static final ImplicitTuple NO_TAG = new ImplicitTuple(true, true);
    private static final ImplicitTuple QUOTED = new ImplicitTuple(false, true);

    private final ScalarResolver resolver = new CoreScalarResolver(false);
    private final Allowance values = new Allowance(YamlReader.MAX_VALUES);
    private final Emitter emitter;

    private YamlWriter(StringBuilder out) {
        emitter =
                new Emitter(
                        SETTINGS,
                        new StreamDataWriter() {
                            @Override
                            public void write(String text) {
                                out.append(text);
                            }

                            @Override
                            public void write(String text, int offset, int length) {
                                out.append(text, offset, offset + length);
                            }
                        });
    }

    /** A number in the tree, in the form of the text that is written. */
    public record Numeral(String text) {
        /** Returns the shortest text that is read as exactly this number. */
        public static Numeral of(double value) {
            boolean negativeZero = value == 0 && 1 / value < 0;
            boolean integer =
                    value == Math.rint(value)
                            && !negativeZero
                            && Math.abs(value) < LARGEST_WRITTEN_AS_INTEGER;
            return new Numeral(integer ? Long.toString((long) value) : Double.toString(value));
        }

        /** Returns the shortest text that is read as exactly this 32-bit number. */
        public static Numeral of(float value) {
            double shortest = Double.parseDouble(Float.toString(value));
            return of((float) shortest == value ? shortest : value);
        }
    }

    /**
     * Returns the YAML of a tree.
     *
     * @param tree may contain maps with String keys, collections, String, Boolean and {@link
     *     Numeral}
     * @throws IllegalArgumentException if the tree has more values than {@link YamlReader} accepts
     */
    public static String write(Map<String, ?> tree) {
        var out = new StringBuilder();
        var writer = new YamlWriter(out);
        writer.emitter.emit(new StreamStartEvent());
        writer.emitter.emit(new DocumentStartEvent(false, Optional.empty(), Map.of()));
        writer.value(tree);
        writer.emitter.emit(new DocumentEndEvent(false));
        writer.emitter.emit(new StreamEndEvent());
        return out.toString();
    }

    private void value(Object value) {
        if (!values.take(1)) {
            throw new IllegalArgumentException(
                    "more than " + YamlReader.MAX_VALUES + " values, which no world file may hold");
        }
        switch (value) {
            case Map<?, ?> mapping -> {
                emitter.emit(
                        new MappingStartEvent(
                                Optional.empty(), Optional.empty(), true, style(mapping.values())));
                mapping.forEach(
                        (key, field) -> {
                            text((String) key);
                            value(field);
                        });
                emitter.emit(new MappingEndEvent());
            }
            case Collection<?> list -> {
                emitter.emit(
                        new SequenceStartEvent(
                                Optional.empty(),
                                Optional.empty(),
                                true,
                                list.stream().anyMatch(Map.class::isInstance)
                                        ? FlowStyle.BLOCK
                                        : style(list)));
                list.forEach(this::value);
                emitter.emit(new SequenceEndEvent());
            }
            case Numeral number -> plain(number.text());
            case Boolean truth -> plain(truth.toString());
            case String text -> text(text);
            case Lines lines -> scalar(lines.text, QUOTED, ScalarStyle.LITERAL);
            default -> throw new IllegalArgumentException("cannot write " + value.getClass());
        }
    }

    private static FlowStyle style(Collection<?> values) {
        return values.stream().anyMatch(YamlWriter::holdsMapping)
                ? FlowStyle.BLOCK
                : FlowStyle.FLOW;
    }

    private static boolean holdsMapping(Object value) {
        return value instanceof Map<?, ?>
                || value instanceof List<?> list
                        && list.stream().anyMatch(YamlWriter::holdsMapping);
    }

    private void plain(String text) {
        scalar(text, NO_TAG, ScalarStyle.PLAIN);
    }

    /** A text of several lines, written unchanged as a YAML block text. */
    record Lines(String text) {}

    /** Writes a text. Quotes it if it would otherwise be read as a number, a boolean or null. */
    private void text(String text) {
        if (!text.codePoints().allMatch(YamlWriter::isPlain)) {
            scalar(text, QUOTED, ScalarStyle.DOUBLE_QUOTED);
        } else if (text.isEmpty() || !resolver.resolve(text, true).equals(Tag.STR)) {
            scalar(text, QUOTED, ScalarStyle.SINGLE_QUOTED);
        } else {
            plain(text);
        }
    }

    /** Returns whether a character is visible and every YAML reader accepts it unescaped. */
    private static boolean isPlain(int codePoint) {
        return codePoint >= ' ' && codePoint <= '~' || Character.isLetterOrDigit(codePoint);
    }

    private void scalar(String text, ImplicitTuple tag, ScalarStyle style) {
        emitter.emit(new ScalarEvent(Optional.empty(), Optional.empty(), tag, text, style));
    }
}
