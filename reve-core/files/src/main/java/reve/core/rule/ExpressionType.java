// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

/** The type of an expression's result. */
public enum ExpressionType {
    /** True or false. */
    TRUTH("true or false"),
    /** One number in SI units. */
    NUMBER("a number"),
    /** A text. */
    TEXT("a text"),
    /** Several values, such as the components of a vector. */
    LIST("a list"),
    /** Any of these types. The type is known only after the evaluation. */
    ANY("a value");

    private final String words;

    ExpressionType(String words) {
        this.words = words;
    }

    /** Returns the type in words, for messages: {@code a number}. */
    public String words() {
        return words;
    }

    /** Returns whether an expression of this type is allowed where another type is required. */
    public boolean suits(ExpressionType asked) {
        return this == asked || this == ANY || asked == ANY;
    }
}
