// SPDX-License-Identifier: Apache-2.0
package reve.agent;

/** Encoding of messages after the hello. */
public enum Encoding {
    /** One JSON object per line. */
    JSON("json"),
    /** MessagePack maps with a length prefix. */
    MESSAGEPACK("msgpack");

    private final String wireName;

    Encoding(String wireName) {
        this.wireName = wireName;
    }

    /** Returns the name in the protocol. */
    String wireName() {
        return wireName;
    }
}
