// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

/**
 * Takes what a world file may not say though a world can come to it: a place beyond all distances,
 * inertia that no body has. A designer's file is refused for it. In a file that was saved from a
 * world that ran, which can hold what laws made of it, it is a warning. Items that a store kept are
 * taken as they are.
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

    /** What is right, and does nothing. */
    void warn(Node node, String message, Problems problems) {
        if (this != IGNORED) {
            problems.warn(node, message);
        }
    }
}
