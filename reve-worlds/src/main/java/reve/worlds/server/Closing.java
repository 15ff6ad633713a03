// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import java.util.ArrayDeque;
import java.util.Deque;

/**
 * Resources that are closed together, the last opened first. One that fails to close does not keep
 * the others open. One thread.
 */
final class Closing implements AutoCloseable {
    private final Deque<AutoCloseable> open = new ArrayDeque<>();

    /** Remembers a resource that was just opened, and hands it back. */
    <T extends AutoCloseable> T add(T resource) {
        open.push(resource);
        return resource;
    }

    /** Closes everything because of a failure, which keeps what goes wrong now. */
    void closeAfter(Throwable failure) {
        while (!open.isEmpty()) {
            try {
                open.pop().close();
            } catch (Exception another) {
                failure.addSuppressed(another);
            }
        }
    }

    /** Closes everything. May be called twice. */
    @Override
    public void close() {
        IllegalStateException failure = new IllegalStateException("not everything could be closed");
        closeAfter(failure);
        if (failure.getSuppressed().length > 0) {
            throw failure;
        }
    }
}
