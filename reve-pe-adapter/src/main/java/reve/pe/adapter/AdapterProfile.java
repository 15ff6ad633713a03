// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

/**
 * Where the adapter's time went so far, wall clock; for people, never for the world.
 *
 * @param frames advanced
 * @param redoneFrames times a frame was done over because a law failed
 * @param bindNanoseconds telling the engine what changed in the world
 * @param copyNanoseconds keeping the columns that laws may write
 * @param advanceNanoseconds inside the engine, redone frames included
 */
public record AdapterProfile(
        long frames,
        long redoneFrames,
        long bindNanoseconds,
        long copyNanoseconds,
        long advanceNanoseconds) {}
