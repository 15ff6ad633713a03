// SPDX-License-Identifier: Apache-2.0
package reve.pe.posix;

/**
 * A part of shared memory that another process can map.
 *
 * @param descriptor file descriptor of the memory, valid in this process
 * @param offset begin of the part in the memory [bytes]
 */
public record SharedPart(int descriptor, long offset) {}
