// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

/** Receives problems of a server's own files while it runs. Must not block. */
@FunctionalInterface
public interface ServerProblems {

    /**
     * A problem has begun, has changed, or is over. Called by the event loop's thread.
     *
     * @param source {@code audit}, {@code tokens} or {@code tls}
     */
    void report(String source, String message);
}
