// SPDX-License-Identifier: Apache-2.0
package reve.core;

/** The source of random inputs of tests. */
public final class Seed {

    private Seed() {}

    /**
     * Returns {@code -Dreve.test.seed=N}, or a new seed; prints it, so that a failure can be
     * repeated.
     */
    public static long of(String what) {
        long seed = Long.getLong("reve.test.seed", System.nanoTime());
        System.out.println("seed of " + what + ": -Dreve.test.seed=" + seed);
        return seed;
    }

    /** Returns the given seed, or a new one if it is 0. */
    public static long of(String what, long given) {
        return given != 0 ? given : of(what);
    }
}
