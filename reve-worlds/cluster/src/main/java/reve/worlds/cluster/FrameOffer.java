// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

/**
 * The answer to {@link WorldCommand.Watch}.
 *
 * @param stream text with which the other node opens the stream of frames; empty if this node does
 *     not run the world now
 */
record FrameOffer(String stream) {}
