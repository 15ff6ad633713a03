// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/** The type of an action's parameter. */
public enum ParameterType {
    /** Type of one or several finite numbers in the parameter's unit. */
    NUMBER,
    /** Type of a text of at most {@link Arguments#MAX_TEXT_LENGTH} characters. */
    TEXT,
    /** Type of a truth value. */
    TRUTH,
    /** Type of a text that is the name of a body. */
    ITEM
}
