// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/** The type of an action's parameter. */
public enum ParameterType {
    /** Finite numbers, one or several, in the parameter's unit. */
    NUMBER,
    /** A text of at most {@link Arguments#MAX_TEXT_LENGTH} characters. */
    TEXT,
    /** True or false. */
    TRUTH,
    /** The name of a body. */
    ITEM
}
