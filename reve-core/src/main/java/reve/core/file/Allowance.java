// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

/** How much of something a file may still take up. */
final class Allowance {
    private long left;

    Allowance(long most) {
        left = most;
    }

    /** Takes so much of it, or nothing and answers false if there is less left. */
    boolean take(long amount) {
        if (amount > left) {
            return false;
        }
        left -= amount;
        return true;
    }
}
