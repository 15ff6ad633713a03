// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import org.apache.pekko.serialization.JSerializer;
import org.jspecify.annotations.Nullable;

/**
 * Encodes the message that wakes a world. It has no content besides the name of the world, which
 * Pekko's envelope contains.
 */
public final class WakeSerializer extends JSerializer {
    /** Number that identifies this serializer. Pekko itself uses the numbers 0 to 40. */
    private static final int IDENTIFIER = 72_301;

    @Override
    public int identifier() {
        return IDENTIFIER;
    }

    @Override
    public boolean includeManifest() {
        return false;
    }

    @Override
    public byte[] toBinary(Object message) {
        if (message instanceof WorldCommand.Wake) {
            return new byte[0];
        }
        throw new IllegalArgumentException(
                "the message " + message + " is for one node and cannot be sent to another");
    }

    @Override
    public Object fromBinaryJava(byte[] bytes, @Nullable Class<?> manifest) {
        if (bytes.length > 0) {
            throw new IllegalArgumentException(
                    "a message of "
                            + bytes.length
                            + " bytes about a world, expected 0: the other node has another"
                            + " version");
        }
        return WorldCommand.Wake.INSTANCE;
    }
}
