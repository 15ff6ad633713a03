// SPDX-License-Identifier: Apache-2.0
package reve.pe.posix;

/**
 * A part of shared memory, as another process can map it.
 *
 * @param descriptor of the memory, valid in this process
 * @param offset where the part begins [bytes]
 */
public record SharedPart(int descriptor, long offset) {}
