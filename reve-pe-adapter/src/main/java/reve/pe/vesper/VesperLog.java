// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

/** A receiver of log lines of the engine and of laws. */
@FunctionalInterface
public interface VesperLog {
    /**
     * Called on the thread that is inside the engine; it must return quickly and must not call the
     * engine.
     */
    void log(System.Logger.Level level, String message);
}
