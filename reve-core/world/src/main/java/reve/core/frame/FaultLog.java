// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.core.world.WorldEvent;

import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Set;

/**
 * Reporter of exceptions that listeners and commands throw. It writes each distinct message once to
 * the log, and raises it once as an event "fault" of the world.
 */
final class FaultLog {

    private static final Logger LOG = LoggerFactory.getLogger(FaultLog.class);
    private static final int MAX_DISTINCT = 1000;

    private final Set<String> reported = new HashSet<>();

    /**
     * Reports a fault, unless the same source has reported the same fault before, or {@link
     * #MAX_DISTINCT} faults were reported.
     */
    void report(FrameEvent event, String source, Throwable fault) {
        String message = String.valueOf(fault.getMessage());
        String type = fault.getClass().getSimpleName();
        if (reported.size() >= MAX_DISTINCT || !reported.add(source + type + message)) {
            return;
        }
        if (reported.size() == MAX_DISTINCT) {
            LOG.warn("{} distinct faults reported; no more will be", MAX_DISTINCT);
        }
        LOG.error("frame {} {}: {} failed", event.frame(), event.phase(), source, fault);
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("phase", event.phase().name());
        fields.put("source", source);
        fields.put("error", type);
        fields.put("message", message);
        event.world().raise(new WorldEvent(event.frame(), "fault", fields));
    }
}
