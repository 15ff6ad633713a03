// SPDX-License-Identifier: Apache-2.0
package reve.core;

/** The source of random inputs of tests. */
public final class Seed {

    private Seed() {}

    /**
     * Returns {@code -Dreve.test.seed=N}, a new seed with {@code -Dreve.test.seed=new}, or a seed
     * that depends on the name only; prints it, so that a failure can be repeated.
     */
    public static long of(String what) {
        String given = System.getProperty("reve.test.seed", "");
        long seed =
                switch (given) {
                    case "" -> what.hashCode();
                    case "new" -> System.nanoTime();
                    default -> Long.parseLong(given);
                };
        System.out.println("seed of " + what + ": -Dreve.test.seed=" + seed);
        return seed;
    }

    /** Returns the given seed, or a new one if it is 0. */
    public static long of(String what, long given) {
        return given != 0 ? given : of(what);
    }
}
