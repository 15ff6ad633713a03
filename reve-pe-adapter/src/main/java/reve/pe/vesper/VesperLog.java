// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

/** A receiver of log lines of the engine and of laws. */
@FunctionalInterface
public interface VesperLog {
    /**
     * Receives a line. The engine calls this method on the thread that called the engine. The
     * method must return quickly and must not call the engine.
     */
    void log(System.Logger.Level level, String message);
}
