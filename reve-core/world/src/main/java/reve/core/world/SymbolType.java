// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/** The type of a semantic symbol. */
public enum SymbolType {
    /** Type of a text. */
    TEXT,
    /** Type of one finite number. */
    NUMBER,
    /** Type of a truth value. */
    TRUTH,
    /**
     * Type of a list of at most {@link SymbolDescriptor#MAX_ELEMENTS} texts, numbers and truth
     * values.
     */
    LIST
}
