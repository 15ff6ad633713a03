// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The clients of a world, as reports describe them. For the event loop's thread, unless stated
 * otherwise.
 */
public interface Clients {

    /** Returns the fields that describe each client, in the order of the clients' names. */
    List<Map<String, Object>> describe();

    /** Describes what an agent perceived last; empty if there is no agent of this name. */
    Optional<Map<String, Object>> perceived(String agent);

    /** Measures the round-trip time to each client. Later descriptions contain the results. */
    void measureRoundTrips();

    /**
     * Notes all sessions again, because a rewind may have changed the bodies. For the world's
     * thread.
     */
    void noteBodies();
}
