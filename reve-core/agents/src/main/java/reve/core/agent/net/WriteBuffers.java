// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import reve.core.agent.perception.Difference;
import reve.core.agent.protocol.Bytes;

import java.nio.ByteBuffer;

/** Buffers of a thread that encodes and writes messages. For one thread. */
public final class WriteBuffers {

    /** Maximum size of one write to a socket [bytes]. */
    public static final int BUFFER_BYTES = 64 * 1024;

    private final Bytes bytes = new Bytes();
    private final ByteBuffer buffer = ByteBuffer.allocateDirect(BUFFER_BYTES);
    private final Difference difference = new Difference();

    /** Returns the empty buffer for encoding a client's messages. */
    Bytes bytes() {
        return bytes.clear();
    }

    /** Returns the empty buffer for socket reads and writes. */
    ByteBuffer buffer() {
        return buffer.clear();
    }

    /** Returns the reusable comparison of two views. */
    Difference difference() {
        return difference;
    }
}
