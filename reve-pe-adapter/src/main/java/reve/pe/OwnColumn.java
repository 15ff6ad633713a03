// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/**
 * The place of a column that a loaded law has of its own ({@link Access#SCRATCH}).
 *
 * @param libraryId id of the library
 * @param law index of the law in {@link PhysicsEngine#laws(int)}
 * @param use index of the column in {@link PhysicsLaw#uses}
 * @param components values per row
 */
public record OwnColumn(int libraryId, int law, int use, int components) {}
