// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/** Outcome of an engine call that failed. */
public enum Status {
    /** An argument is null, out of range or not finite. */
    INVALID_ARGUMENT,
    /** No property, law, library or prototype of that name. */
    NOT_FOUND,
    /** The name is taken. */
    ALREADY_EXISTS,
    /** The engine is inside {@link PhysicsEngine#advance}. */
    BUSY,
    /** A library was built for another contract version. */
    ABI_MISMATCH,
    /** Scalar type or number of components differ. */
    TYPE_MISMATCH,
    /** Units differ in dimension or in scale. */
    UNIT_MISMATCH,
    /** Properties of one kind have different row counts. */
    COUNT_MISMATCH,
    /** A law asks for more than allowed, or two laws collide. */
    ACCESS_CONFLICT,
    /** The file is no complete, loadable law library. */
    LIBRARY_LOAD_FAILED,
    /** A law returned an error or threw. */
    LAW_FAILED,
    /** A law broke its declaration, or wrote NaN or infinity. */
    LAW_MISBEHAVED,
    /** A step failed before; see {@link PhysicsEngine#clearFault}. */
    FAULTED,
    /** A bug of the engine. */
    INTERNAL,
    /** A status that this program does not know: the engine is newer. */
    UNKNOWN
}
