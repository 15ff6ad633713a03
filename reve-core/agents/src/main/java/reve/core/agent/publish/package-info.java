// SPDX-License-Identifier: Apache-2.0
/**
 * What a frame brings to the clients of a world: perceptions, events and pictures. The event loop's
 * thread.
 */
@NullMarked
package reve.core.agent.publish;

import org.jspecify.annotations.NullMarked;
