// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.pe.PhysicsEngine;
import reve.pe.Prototype;
import reve.pe.adapter.SharedArena;
import reve.pe.hosted.ApartRule;
import reve.pe.hosted.HostedEngine;
import reve.pe.hosted.Hosts;
import reve.pe.vesper.VesperConfig;
import reve.pe.vesper.VesperEngine;

import java.time.Duration;

/** The process in which a world's engine and laws run. */
public interface EnginePlace {
    /** The server's own process. A law that crashes ends the server. */
    EnginePlace IN_PROCESS =
            (config, prototype, apart, arena) -> new VesperEngine(config, prototype);

    /**
     * Creates an engine.
     *
     * @param apart decides which libraries run in a sandbox; has no effect if the engine runs in
     *     the server's own process, which has no sandbox
     * @param arena memory of the columns that the engine will use
     */
    PhysicsEngine engine(
            VesperConfig config, Prototype prototype, ApartRule apart, SharedArena arena);

    /**
     * Returns a place that starts a separate process for each engine. The crash of a law ends only
     * this process, and the world repeats one frame.
     */
    static EnginePlace hosted(Hosts hosts, Duration frameLimit) {
        return (config, prototype, apart, arena) ->
                new HostedEngine(hosts, frameLimit, config, prototype, apart, arena::part);
    }
}
