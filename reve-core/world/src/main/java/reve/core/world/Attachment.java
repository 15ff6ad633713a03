// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/**
 * What an item moves with. Immutable.
 *
 * @param parent the item it is attached to
 * @param pose its place and rotation in the parent's own frame
 */
public record Attachment(ItemId parent, Pose pose) {}
