// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import org.apache.pekko.actor.ExtendedActorSystem;
import org.apache.pekko.actor.typed.ActorRefResolver;
import org.apache.pekko.actor.typed.javadsl.Adapter;
import org.apache.pekko.serialization.SerializerWithStringManifest;

import java.io.NotSerializableException;
import java.nio.charset.StandardCharsets;

/** Encodes the request of a node for the frames of a world, and the answer, as texts. */
public final class WatchSerializer extends SerializerWithStringManifest {
    /** Number that identifies this serializer. Pekko itself uses the numbers 0 to 40. */
    private static final int IDENTIFIER = 72_302;

    private static final String WATCH = "watch";
    private static final String OFFER = "offer";

    private final ExtendedActorSystem system;

    /** Creates the serializer of a node; Pekko calls this constructor. */
    public WatchSerializer(ExtendedActorSystem system) {
        this.system = system;
    }

    @Override
    public int identifier() {
        return IDENTIFIER;
    }

    @Override
    public String manifest(Object message) {
        return message instanceof FrameOffer ? OFFER : WATCH;
    }

    @Override
    public byte[] toBinary(Object message) {
        String text =
                switch (message) {
                    case WorldCommand.Watch watch ->
                            resolver().toSerializationFormat(watch.reader());
                    case FrameOffer offer -> offer.stream();
                    default ->
                            throw new IllegalArgumentException(
                                    "the message " + message + " cannot be sent to another node");
                };
        return text.getBytes(StandardCharsets.UTF_8);
    }

    @Override
    public Object fromBinary(byte[] bytes, String manifest) throws NotSerializableException {
        String text = new String(bytes, StandardCharsets.UTF_8);
        return switch (manifest) {
            case WATCH -> new WorldCommand.Watch(resolver().resolveActorRef(text));
            case OFFER -> new FrameOffer(text);
            default ->
                    throw new NotSerializableException(
                            "a message '" + manifest + "': the other node has another version");
        };
    }

    private ActorRefResolver resolver() {
        return ActorRefResolver.get(Adapter.toTyped(system));
    }
}
