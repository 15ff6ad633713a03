// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import reve.pe.Prototype;
import reve.pe.vesper.VesperConfig;

import java.util.function.Consumer;

/** Requests to a host; a failure becomes a PhysicsException. */
@FunctionalInterface
interface Calls {
    /** Sends the request that the caller writes, and returns the reply behind its status. */
    Mailbox call(Consumer<HostProcess> request) throws HostLost;

    /** Creates the engine of a host. */
    default void create(VesperConfig config, int threads, Prototype prototype) throws HostLost {
        call(
                to ->
                        Wire.put(
                                to.begin(Request.CREATE)
                                        .putInt(threads)
                                        .putInt(config.validate() ? 1 : 0),
                                prototype));
    }
}
