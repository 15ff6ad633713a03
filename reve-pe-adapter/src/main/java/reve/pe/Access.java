// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/**
 * What a law does to a property. A set of these says what one law does (read and write together
 * mean in-place update), or the most that any law may do.
 */
public enum Access {
    /** Reads the rows. */
    READ,
    /** Writes every row before it returns. */
    WRITE,
    /** Adds to the rows; the engine zeroes them and sums over laws. */
    ACCUMULATE,
    /** No property of the client: memory that the engine keeps for the law, row by row. */
    SCRATCH
}
