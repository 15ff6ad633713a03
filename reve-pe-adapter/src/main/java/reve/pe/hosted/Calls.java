// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import reve.pe.Prototype;
import reve.pe.vesper.VesperConfig;

import java.util.function.Consumer;

/**
 * Requests to a host (a process that runs an engine). A failure that the host reports is thrown as
 * a PhysicsException.
 */
@FunctionalInterface
interface Calls {
    /**
     * Sends the request that {@code request} writes, and returns the reply. The position in the
     * reply is after its status.
     */
    Mailbox call(Consumer<HostProcess> request) throws HostLost;

    /** Makes a host create its engine. */
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
