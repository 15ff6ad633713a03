// SPDX-License-Identifier: Apache-2.0
package reve.core;

/** Where the random inputs of tests come from. */
public final class Seed {

    private Seed() {}

    /** {@code -Dreve.test.seed=N}, or a new one; printed, so that a failure can be repeated. */
    public static long of(String what) {
        long seed = Long.getLong("reve.test.seed", System.nanoTime());
        System.out.println("seed of " + what + ": -Dreve.test.seed=" + seed);
        return seed;
    }

    /** The given one, or as the other if that is 0. */
    public static long of(String what, long given) {
        return given != 0 ? given : of(what);
    }
}
