// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import java.util.List;
import java.util.Map;

/** Writes the values of one message, in one {@link Encoding}. One thread. */
public interface MessageWriter {

    /** Begins an object of that many fields. */
    void beginMap(int fields);

    /** Ends an object. */
    void endMap();

    /** Begins a list of that many values. */
    void beginList(int values);

    /** Ends a list. */
    void endList();

    /** The name of the field whose value comes next. */
    void key(String name);

    /** Writes a text. */
    void text(String text);

    /** Writes a truth value. */
    void truth(boolean truth);

    /** Writes an integer. */
    void integer(long number);

    /**
     * @param number finite
     */
    void number(double number);

    /** A value that many messages hold. */
    void fragment(Fragment fragment);

    /** Returns how values are written. */
    Encoding encoding();

    /** In JSON a text, in base64 (RFC 4648). */
    void bytes(byte[] bytes);

    /** {@code count} numbers from {@code first} on. */
    default void numbers(double[] numbers, int first, int count) {
        beginList(count);
        for (int i = first; i < first + count; i++) {
            number(numbers[i]);
        }
        endList();
    }

    /**
     * String, Boolean, Number, byte[], or a List or a Map by text of such. What is not finite is
     * written as text.
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
