// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

/**
 * The treatment of doubtful values. A doubtful value is a place beyond all limits, or inertia that
 * no body can have. Laws may produce such values, but a designer should not write them.
 *
 * <ul>
 *   <li>REFUSED: the file is refused. This treatment is for files of designers.
 *   <li>WARNED: a warning reports the value. This treatment is for files saved from a running
 *       world.
 *   <li>IGNORED: the value is accepted. This treatment is for items from a store.
 * </ul>
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

    /** Records a warning for a value that is valid but has no effect, unless doubts are ignored. */
    void warn(Node node, String message, Problems problems) {
        if (this != IGNORED) {
            problems.warn(node, message);
        }
    }
}
