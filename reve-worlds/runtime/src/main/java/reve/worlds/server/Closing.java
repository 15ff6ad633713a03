// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import java.util.ArrayDeque;
import java.util.Deque;

/**
 * Resources that are closed together in reverse order of opening. A failure to close one resource
 * does not prevent the closing of the others. For one thread.
 */
final class Closing implements AutoCloseable {
    private final Deque<AutoCloseable> open = new ArrayDeque<>();

    /** Adds a resource that was just opened, and returns it. */
    <T extends AutoCloseable> T add(T resource) {
        open.push(resource);
        return resource;
    }

    /**
     * Closes all resources because of a failure. Exceptions while closing are added to this failure
     * as suppressed exceptions.
     */
    void closeAfter(Throwable failure) {
        while (!open.isEmpty()) {
            try {
                open.pop().close();
            } catch (Exception another) {
                failure.addSuppressed(another);
            }
        }
    }

    /** Closes all resources. Idempotent. */
    @Override
    public void close() {
        IllegalStateException failure = new IllegalStateException("not everything could be closed");
        closeAfter(failure);
        if (failure.getSuppressed().length > 0) {
            throw failure;
        }
    }
}
