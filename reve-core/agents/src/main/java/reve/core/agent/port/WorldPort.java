// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

import reve.core.file.AgentPolicy;
import reve.core.frame.CommandQueue;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.world.SnapshotRing;

/**
 * What the server needs of a running world.
 *
 * @param world the world's name
 * @param framesPerSecond its frame rate, for agents to know
 * @param agents which bodies it grants
 * @param bus where the server hears that a frame was published; whoever publishes snapshots
 *     subscribes to PUBLISH before the server is started, so that the server finds the frame's
 *     snapshot there
 * @param commands takes what agents want into the next frame
 * @param snapshots what agents perceive
 * @param loop makes the frames
 * @param control what else clients of the role control may do
 * @param cameras takes the pictures of bodies' cameras
 */
public record WorldPort(
        String world,
        int framesPerSecond,
        AgentPolicy agents,
        FrameBus bus,
        CommandQueue commands,
        SnapshotRing snapshots,
        FrameLoop loop,
        WorldControl control,
        Cameras cameras) {}
