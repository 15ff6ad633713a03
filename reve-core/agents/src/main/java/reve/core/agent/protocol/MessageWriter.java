// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import java.util.List;
import java.util.Map;

/** Writer of the values of one message in one {@link Encoding}. For one thread. */
public interface MessageWriter {

    /** Begins an object with that number of fields. */
    void beginMap(int fields);

    /** Ends an object. */
    void endMap();

    /** Begins a list with that number of values. */
    void beginList(int values);

    /** Ends a list. */
    void endList();

    /** Writes the name of the next field. */
    void key(String name);

    /** Writes a text. */
    void text(String text);

    /** Writes a truth value. */
    void truth(boolean truth);

    /** Writes an integer. */
    void integer(long number);

    /**
     * Writes a finite number.
     *
     * @param number finite
     */
    void number(double number);

    /** Writes a value whose encoding several messages share. */
    void fragment(Fragment fragment);

    /** Returns the encoding. */
    Encoding encoding();

    /** Writes bytes. In JSON they are a base64 text (RFC 4648). */
    void bytes(byte[] bytes);

    /** Writes {@code count} elements of an array as a list, starting at index {@code first}. */
    default void numbers(double[] numbers, int first, int count) {
        beginList(count);
        for (int i = first; i < first + count; i++) {
            number(numbers[i]);
        }
        endList();
    }

    /**
     * Writes a String, Boolean, Number, byte[], Fragment, or a List or Map of such values, with
     * texts as keys. Numbers that are not finite are written as text.
     */
    default void value(Object value) {
        switch (value) {
            case String text -> text(text);
            case Boolean truth -> truth(truth);
            case Integer number -> integer(number);
            case Long number -> integer(number);
            case Number number when Double.isFinite(number.doubleValue()) ->
                    number(number.doubleValue());
            case Number number -> text(Double.toString(number.doubleValue()));
            case byte[] bytes -> bytes(bytes);
            case Fragment fragment -> fragment(fragment);
            case List<?> list -> {
                beginList(list.size());
                list.forEach(this::value);
                endList();
            }
            case Map<?, ?> map -> {
                beginMap(map.size());
                map.forEach(
                        (name, field) -> {
                            key((String) name);
                            value(field);
                        });
                endMap();
            }
            default ->
                    throw new IllegalArgumentException(
                            "a "
                                    + value.getClass().getSimpleName()
                                    + " has no form in the agent protocol");
        }
    }
}
