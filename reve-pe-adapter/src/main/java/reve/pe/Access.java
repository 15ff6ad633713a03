// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/**
 * The kind of access of a law to a property. A set of these values is the access of one law, or the
 * maximum access that a property permits to any law. Read and write together mean in-place update.
 */
public enum Access {
    /** Reads the rows. */
    READ,
    /** Writes every row before it returns. */
    WRITE,
    /** Adds to the rows; the engine zeroes them before each evaluation, and sums over the laws. */
    ACCUMULATE,
    /**
     * Uses memory that the engine keeps for the law, for each row. The client has no such array.
     */
    SCRATCH
}
