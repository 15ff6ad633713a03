// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/**
 * The attachment of an item to a parent. Immutable.
 *
 * @param parent the item to which it is attached
 * @param pose location and orientation relative to the parent
 */
public record Attachment(ItemId parent, Pose pose) {}
