// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

/** The remaining amount of a limited resource, for example bytes. */
final class Allowance {
    private final long most;
    private long left;

    Allowance(long most) {
        this.most = most;
        left = most;
    }

    /** Returns the amount at the beginning. */
    long most() {
        return most;
    }

    /** Takes an amount and returns true. Takes nothing and returns false if less is left. */
    boolean take(long amount) {
        if (amount > left) {
            return false;
        }
        left -= amount;
        return true;
    }
}
