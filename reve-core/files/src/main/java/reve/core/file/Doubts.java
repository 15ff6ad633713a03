// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

/**
 * The treatment of doubtful values, which laws may produce but a designer should not write: a place
 * beyond all limits, or inertia that no body can have. REFUSED, for files of designers: the file is
 * refused. WARNED, for files saved from a running world: a warning. IGNORED, for items from a
 * store.
 */
enum Doubts {
    REFUSED,
    WARNED,
    IGNORED;

    static Doubts of(boolean ran) {
        return ran ? WARNED : REFUSED;
    }

    void refuse(Node node, String message, Problems problems) {
        switch (this) {
            case REFUSED -> problems.add(node, message);
            case WARNED -> problems.warn(node, message);
            case IGNORED -> {}
        }
    }

    /** Notes a warning, unless doubts are ignored, for a value that is valid but has no effect. */
    void warn(Node node, String message, Problems problems) {
        if (this != IGNORED) {
            problems.warn(node, message);
        }
    }
}
