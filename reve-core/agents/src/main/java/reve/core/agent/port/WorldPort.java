// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

import reve.core.file.AgentPolicy;
import reve.core.frame.CommandQueue;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.world.SnapshotRing;

/**
 * The parts of a running world that the agent server uses.
 *
 * @param world the world's name
 * @param framesPerSecond its frame rate, which the server sends to agents
 * @param agents the bodies and limits that the world grants to agents
 * @param bus notifies the server of published frames. The listener that publishes snapshots must
 *     subscribe to the phase PUBLISH before the server does, so that the server finds the snapshot
 *     of the frame
 * @param commands queue of commands for the next frame
 * @param snapshots ring of snapshots, from which perceptions are computed
 * @param loop makes the frames
 * @param control further commands for clients of the role control
 * @param cameras source of pictures from the cameras of bodies
 * @param notes place where the world keeps the notes about its sessions
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
        Cameras cameras,
        SessionNotes notes) {

    /** Creates the port of a world that keeps no notes about its sessions. */
    public WorldPort(
            String world,
            int framesPerSecond,
            AgentPolicy agents,
            FrameBus bus,
            CommandQueue commands,
            SnapshotRing snapshots,
            FrameLoop loop,
            WorldControl control,
            Cameras cameras) {
        this(
                world,
                framesPerSecond,
                agents,
                bus,
                commands,
                snapshots,
                loop,
                control,
                cameras,
                SessionNotes.NONE);
    }
}
