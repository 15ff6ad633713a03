// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

/**
 * The treatment of values that a world may reach but a designer should not write: a place beyond
 * all limits, or inertia that no body can have. A designer's file is refused. A file saved from a
 * running world, where laws may have produced the value, gets a warning. Items from a store are
 * accepted silently.
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

    /** Notes a warning for a value that is valid and has no effect. */
    void warn(Node node, String message, Problems problems) {
        if (this != IGNORED) {
            problems.warn(node, message);
        }
    }
}
