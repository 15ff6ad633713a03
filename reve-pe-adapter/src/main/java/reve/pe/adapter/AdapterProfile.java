// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

/**
 * The adapter's wall-clock times so far; for reports only.
 *
 * @param frames number of frames so far
 * @param redoneFrames number of frame repetitions after a law had failed
 * @param bindNanoseconds time for passing changes of the world to the engine [ns]
 * @param copyNanoseconds time for copying the columns that laws may write [ns]
 * @param advanceNanoseconds time inside the engine, including repeated frames [ns]
 */
public record AdapterProfile(
        long frames,
        long redoneFrames,
        long bindNanoseconds,
        long copyNanoseconds,
        long advanceNanoseconds) {}
