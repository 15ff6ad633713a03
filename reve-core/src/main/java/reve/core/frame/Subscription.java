// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/** A listener's place on the bus. */
public interface Subscription extends AutoCloseable {

    /** Ends it; at once between frames, from the next dispatch on during one. Idempotent. */
    @Override
    void close();
}
