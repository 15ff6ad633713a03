// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

/** The remaining amount of a limited resource, for example bytes. */
final class Allowance {
    private long left;

    Allowance(long most) {
        left = most;
    }

    /** Takes an amount and returns true. If less is left, takes nothing and returns false. */
    boolean take(long amount) {
        if (amount > left) {
            return false;
        }
        left -= amount;
        return true;
    }
}
