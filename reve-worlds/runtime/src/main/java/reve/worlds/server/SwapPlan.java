// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.frame.LawSwap;

import java.util.Optional;

/**
 * The way in which new versions of loaded laws take over.
 *
 * @param swap the way for all versions; if empty, native code and Python are tried in the shadow,
 *     and texts and new parameters of loaded versions take over at once
 * @param seconds world time that a trial covers [s], above 0
 * @param energyLimit maximum gain of energy in a trial, as a multiple of the energies that {@link
 *     ShadowEnergy} compares it with; above 0
 */
public record SwapPlan(Optional<LawSwap> swap, double seconds, double energyLimit) {
    /** World time that a trial covers, unless the operator gives another time [s]. */
    public static final double DEFAULT_SECONDS = 1;

    /** Limit of the gain of energy, unless the operator gives another limit. */
    public static final double DEFAULT_ENERGY_LIMIT = 10;

    /**
     * The standard plan: native code and Python are tried in the shadow, and texts and new
     * parameters take over at once.
     */
    public static final SwapPlan STANDARD =
            new SwapPlan(Optional.empty(), DEFAULT_SECONDS, DEFAULT_ENERGY_LIMIT);

    /** Checks the numbers. */
    public SwapPlan {
        if (!(seconds > 0) || !(energyLimit > 0)) {
            throw new IllegalArgumentException(
                    "a trial of "
                            + seconds
                            + " s with an energy limit of "
                            + energyLimit
                            + ", expected numbers above 0");
        }
    }

    /** Returns whether a new version is tried in the shadow. */
    boolean isShadowed(boolean text, Optional<LawSwap> asked) {
        return asked.or(() -> swap).orElse(text ? LawSwap.AT_ONCE : LawSwap.SHADOW)
                == LawSwap.SHADOW;
    }

    /** Returns whether new parameters of a loaded library are tried in the shadow. */
    boolean areParametersShadowed(Optional<LawSwap> asked) {
        return asked.or(() -> swap).orElse(LawSwap.AT_ONCE) == LawSwap.SHADOW;
    }
}
