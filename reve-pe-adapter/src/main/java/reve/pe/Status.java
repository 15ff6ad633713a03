// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/** The reason why an engine call failed. */
public enum Status {
    /** An argument is null, out of range or not finite. */
    INVALID_ARGUMENT,
    /** There is no property, law, library or prototype of that name. */
    NOT_FOUND,
    /** The name is already in use. */
    ALREADY_EXISTS,
    /** The engine is inside {@link PhysicsEngine#advance}. */
    BUSY,
    /** A library was built for another version of the binary contract (ABI). */
    ABI_MISMATCH,
    /** Scalar type or number of components differ. */
    TYPE_MISMATCH,
    /** Units differ in dimension or in scale. */
    UNIT_MISMATCH,
    /** Properties of one kind have different row counts. */
    COUNT_MISMATCH,
    /** A law requests more access than permitted, or two laws conflict. */
    ACCESS_CONFLICT,
    /** The file is not a complete, loadable law library. */
    LIBRARY_LOAD_FAILED,
    /** A law returned an error or threw. */
    LAW_FAILED,
    /** A law violated its declaration, or wrote NaN or infinity. */
    LAW_MISBEHAVED,
    /** An earlier step failed; see {@link PhysicsEngine#clearFault}. */
    FAULTED,
    /** A bug of the engine. */
    INTERNAL,
    /** An unknown status of a newer engine. */
    UNKNOWN,
    /** A law ended the process of the engine. */
    LAW_CRASHED,
    /** A law did not return before the deadline of the frame. */
    LAW_TIMED_OUT,
    /** The process of the engine ended, and no law is known to be the cause. */
    ENGINE_LOST
}
