// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.pe.PhysicsEngine;
import reve.pe.Prototype;
import reve.pe.adapter.SharedArena;
import reve.pe.hosted.HostedEngine;
import reve.pe.hosted.Hosts;
import reve.pe.vesper.VesperConfig;
import reve.pe.vesper.VesperEngine;

import java.time.Duration;

/** The place where a world's engine and its laws run. */
public interface EnginePlace {
    /** This process: a law that crashes ends it. */
    EnginePlace IN_PROCESS = (config, prototype, arena) -> new VesperEngine(config, prototype);

    /**
     * Creates an engine.
     *
     * @param arena of the columns that will be lent to it
     */
    PhysicsEngine engine(VesperConfig config, Prototype prototype, SharedArena arena);

    /** Returns a process for each engine: a law that crashes costs one repeated frame. */
    static EnginePlace hosted(Hosts hosts, Duration frameLimit) {
        return (config, prototype, arena) ->
                new HostedEngine(hosts, frameLimit, config, prototype, arena::part);
    }
}
