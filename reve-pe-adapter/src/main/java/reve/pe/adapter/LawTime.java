// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

/**
 * The wall-clock time of a law in the last frames, without frames that were repeated. It is for
 * reports only.
 *
 * @param frames number of these frames
 * @param medianNanoseconds its median time in a frame [ns]
 * @param p99Nanoseconds the time that the law exceeds in one frame of a hundred [ns]
 * @param share the law's part of the time in which the world's thread made these frames, 0 to 1;
 *     the full time of each law counts even if several laws run at the same time
 */
public record LawTime(int frames, long medianNanoseconds, long p99Nanoseconds, double share) {}
