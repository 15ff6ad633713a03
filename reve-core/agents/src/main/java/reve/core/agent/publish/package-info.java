// SPDX-License-Identifier: Apache-2.0
/**
 * Sending of perceptions, events and pictures of frames to the clients of a world. For the event
 * loop's thread.
 */
@NullMarked
package reve.core.agent.publish;

import org.jspecify.annotations.NullMarked;
