// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

/** Receives problems of a server's own files while it runs. Must not block. */
@FunctionalInterface
public interface ServerProblems {

    /**
     * Called on the event loop's thread when a problem begins, changes or ends.
     *
     * @param source {@code audit}, {@code tokens} or {@code tls}
     */
    void report(String source, String message);
}
