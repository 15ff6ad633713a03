// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/** The type of a semantic symbol. */
public enum SymbolType {
    /** A text. */
    TEXT,
    /** One finite number. */
    NUMBER,
    /** True or false. */
    TRUTH,
    /** Texts, numbers and truth values, at most {@link SymbolDescriptor#MAX_ELEMENTS}. */
    LIST
}
