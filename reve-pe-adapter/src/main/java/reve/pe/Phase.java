// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/** The part of a step in which a law runs. Laws run in order of phase, then in order of loading. */
public enum Phase {
    /** Accumulates forces and torques. */
    FORCE,
    /** Moves the state by dt. */
    INTEGRATE,
    /** Corrects the moved state. */
    CONSTRAIN,
    /** Reads the result of the step. */
    OBSERVE
}
