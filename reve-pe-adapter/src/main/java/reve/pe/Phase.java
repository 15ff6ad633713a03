// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/** When a law runs within a step. Order of execution: phase, then order of loading. */
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
