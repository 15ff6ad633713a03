// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/** A subscription of a listener to the bus. */
public interface Subscription extends AutoCloseable {

    /**
     * Ends the subscription. A dispatch in progress may still call the listener, but later
     * dispatches do not. Idempotent.
     */
    @Override
    void close();
}
