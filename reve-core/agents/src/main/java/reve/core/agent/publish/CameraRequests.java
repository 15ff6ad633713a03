// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.publish;

import reve.core.agent.net.RateLimitedLog;
import reve.core.agent.port.Cameras;
import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.ServerMessage;
import reve.core.agent.protocol.Text;
import reve.core.world.ItemId;
import reve.core.world.Sensor;

import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalLong;
import java.util.function.Consumer;

/**
 * The requests of one client for pictures from the cameras of bodies. One request is processed at a
 * time. The interval of a camera limits how often it takes a picture. For the event loop's thread
 * only.
 */
public final class CameraRequests {

    /** Number of cameras whose last picture is remembered. */
    private static final int MOST_CAMERAS = 1024;

    /**
     * A camera of a body.
     *
     * @param body empty for the client's own body, which a rewind may replace by another one. The
     *     interval of the camera continues then
     * @param name name of the sensor
     */
    private record Mounted(Optional<ItemId> body, String name) {
        static Mounted of(ClientMessage.Look look, ItemId body, Sensor camera) {
            return new Mounted(look.item().map(_ -> body), camera.name());
        }
    }

    private final Cameras cameras;
    private final Publisher publisher;
    private final RateLimitedLog log;
    private final String client;
    private final Consumer<ServerMessage> told;

    /** The frame of the last picture of each camera. The oldest pictures are forgotten. */
    private final Map<Mounted, Long> lastFrames =
            new LinkedHashMap<>() {
                private static final long serialVersionUID = 1;

                @Override
                protected boolean removeEldestEntry(Map.Entry<Mounted, Long> eldest) {
                    return size() > MOST_CAMERAS;
                }
            };

    /** Id of the request that is being processed. */
    private OptionalLong pending = OptionalLong.empty();

    /**
     * @param client name of the client for the log
     * @param told receives the answers to the client
     */
    public CameraRequests(
            Cameras cameras,
            Publisher publisher,
            RateLimitedLog log,
            String client,
            Consumer<ServerMessage> told) {
        this.cameras = cameras;
        this.publisher = publisher;
        this.log = log;
        this.client = client;
        this.told = told;
    }

    /**
     * Requests a picture from a camera.
     *
     * @throws BadMessage if another picture is pending, or the camera's interval has not passed
     */
    public void take(ClientMessage.Look look, ItemId body, Sensor camera) throws BadMessage {
        if (pending.equals(OptionalLong.of(look.id()))) {
            // The client repeated its request over a new connection. The answer to the first
            // request will be sent.
            return;
        }
        if (pending.isPresent()) {
            throw new BadMessage(
                    look.id(),
                    "look-pending",
                    "the picture asked for before is still on its way",
                    "wait for it");
        }
        requireTurn(look, Mounted.of(look, body, camera), camera, publisher.published());
        pending = OptionalLong.of(look.id());
        cameras.take(
                body,
                camera,
                new Cameras.Answer() {
                    @Override
                    public void taken(Cameras.Photo photo) {
                        publisher.later(() -> show(look, body, camera, photo));
                    }

                    @Override
                    public void refused(String reason) {
                        publisher.later(
                                () ->
                                        tell(
                                                new ServerMessage.Error(
                                                        look.id(),
                                                        "no-picture",
                                                        reason,
                                                        "try again")));
                    }

                    @Override
                    public void failed(RuntimeException cause) {
                        log.error("a picture for " + client + " could not be drawn", cause);
                        refused("the picture could not be drawn; the server's log says" + " why");
                    }
                });
    }

    /**
     * Throws an exception unless a new picture may be taken. A picture may be taken if the camera's
     * interval has passed since its last picture. Another picture of the same frame is also
     * allowed.
     */
    private void requireTurn(ClientMessage.Look look, Mounted mounted, Sensor camera, long frame)
            throws BadMessage {
        long last = lastFrames.getOrDefault(mounted, Long.MIN_VALUE / 2);
        long next = last + camera.every();
        if (frame > last && frame < next) {
            throw new BadMessage(
                    look.id(),
                    "not-yet",
                    "the camera "
                            + Text.quote(camera.name())
                            + " takes a picture every "
                            + camera.every()
                            + " frames",
                    "look again from frame " + next + " on");
        }
    }

    private void show(ClientMessage.Look look, ItemId body, Sensor camera, Cameras.Photo photo) {
        var mounted = Mounted.of(look, body, camera);
        try {
            requireTurn(look, mounted, camera, photo.frame());
            lastFrames.remove(mounted); // so that it becomes the newest
            lastFrames.put(mounted, photo.frame());
            tell(new ServerMessage.Image(look.id(), camera.name(), photo));
        } catch (BadMessage tooEarly) { // the world made frames while the picture was drawn
            tell(tooEarly.error());
        }
    }

    private void tell(ServerMessage answer) {
        pending = OptionalLong.empty();
        told.accept(answer);
    }
}
