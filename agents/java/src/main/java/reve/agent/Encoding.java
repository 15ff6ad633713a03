// SPDX-License-Identifier: Apache-2.0
package reve.agent;

/** How messages are written after the hello. */
public enum Encoding {
    /** One JSON object per line. */
    JSON("json"),
    /** MessagePack maps behind their length. */
    MESSAGEPACK("msgpack");

    private final String wireName;

    Encoding(String wireName) {
        this.wireName = wireName;
    }

    /** As the protocol writes it. */
    String wireName() {
        return wireName;
    }
}
