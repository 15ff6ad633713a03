// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/** The part of a step in which a law runs. Laws run in order of phase, then in order of loading. */
public enum Phase {
    /** Phase of laws that accumulate forces and torques. */
    FORCE,
    /** Phase of laws that move the state by the length of a step. */
    INTEGRATE,
    /** Phase of laws that correct the moved state. */
    CONSTRAIN,
    /** Phase of laws that read the result of the step. */
    OBSERVE
}
