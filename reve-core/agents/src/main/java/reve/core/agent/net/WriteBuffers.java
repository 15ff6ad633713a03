// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import reve.core.agent.perception.Difference;
import reve.core.agent.protocol.Bytes;

import java.nio.ByteBuffer;

/** What a thread that writes to clients puts their messages together with. One thread. */
public final class WriteBuffers {

    /** So much is handed to a socket at once. */
    public static final int BUFFER_BYTES = 64 * 1024;

    private final Bytes bytes = new Bytes();
    private final ByteBuffer buffer = ByteBuffer.allocateDirect(BUFFER_BYTES);
    private final Difference difference = new Difference();

    /** Where what goes to one client is put together; empty. */
    Bytes bytes() {
        return bytes.clear();
    }

    /** What a socket takes from, or gives to; empty. */
    ByteBuffer buffer() {
        return buffer.clear();
    }

    /** Finds what is different in what one client is told. */
    Difference difference() {
        return difference;
    }
}
