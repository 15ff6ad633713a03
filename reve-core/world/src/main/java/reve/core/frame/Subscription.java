// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/** A subscription of a listener to the bus. */
public interface Subscription extends AutoCloseable {

    /**
     * Ends the subscription: at once between frames, from the next dispatch on during a frame.
     * Idempotent.
     */
    @Override
    void close();
}
