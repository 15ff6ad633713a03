// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/**
 * The kind of access of a law to a property. A set of these is the access of one law (read and
 * write together mean in-place update), or the maximum that any law may have.
 */
public enum Access {
    /** Reads the rows. */
    READ,
    /** Writes every row before it returns. */
    WRITE,
    /** Adds to the rows; the engine zeroes them and sums over laws. */
    ACCUMULATE,
    /** Uses memory that the engine keeps for the law, row by row; not a property of the client. */
    SCRATCH
}
