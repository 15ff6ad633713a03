// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/**
 * The kind of access of a law to a property. A set of these values is the access of one law, or the
 * maximum access that a property permits to any law. The values READ and WRITE together mean that
 * the law updates the property in place.
 */
public enum Access {
    /** Access of a law that reads the rows. */
    READ,
    /** Access of a law that writes every row before it returns. */
    WRITE,
    /**
     * Access of a law that adds to the rows. The engine zeroes the rows before each evaluation, so
     * they contain the sum over all laws.
     */
    ACCUMULATE,
    /**
     * Access of a law to its own memory for each row. The engine keeps this memory, and the client
     * has no such array.
     */
    SCRATCH
}
