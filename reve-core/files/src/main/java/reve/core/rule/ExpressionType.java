// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

/** What an expression gives. */
public enum ExpressionType {
    /** True or false. */
    TRUTH("true or false"),
    /** One number in SI units. */
    NUMBER("a number"),
    /** A text. */
    TEXT("a text"),
    /** Several values, such as the three numbers of a vector. */
    LIST("a list"),
    /** One of these, which only its evaluation shows. */
    ANY("a value");

    private final String words;

    ExpressionType(String words) {
        this.words = words;
    }

    /** In words, for messages: {@code a number}. */
    public String words() {
        return words;
    }

    /** Whether an expression of this type may stand where another type is asked for. */
    public boolean suits(ExpressionType asked) {
        return this == asked || this == ANY || asked == ANY;
    }
}
