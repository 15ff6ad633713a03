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

import java.util.HashMap;
import java.util.Map;
import java.util.OptionalLong;
import java.util.function.Consumer;

/**
 * The requests of one client for pictures from its body's cameras. One request is processed at a
 * time. The interval of a camera limits how often it takes a picture. For the event loop's thread
 * only.
 */
public final class CameraRequests {

    private final Cameras cameras;
    private final Publisher publisher;
    private final RateLimitedLog log;
    private final String client;
    private final Consumer<ServerMessage> told;
    private final Map<String, Long> lastFrames = new HashMap<>();

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
     * @throws BadMessage if another picture is pending, or the camera's interval has not passed
     */
    public void take(ClientMessage.Look look, ItemId body, Sensor camera) throws BadMessage {
        if (pending.equals(OptionalLong.of(look.id()))) {
            return; // the client repeated its request over a new connection, and the answer to
            // the first request follows
        }
        if (pending.isPresent()) {
            throw new BadMessage(
                    look.id(),
                    "look-pending",
                    "the picture asked for before is still on its way",
                    "wait for it");
        }
        requireTurn(look, camera, publisher.published());
        pending = OptionalLong.of(look.id());
        cameras.take(
                body,
                camera,
                new Cameras.Answer() {
                    @Override
                    public void taken(Cameras.Photo photo) {
                        publisher.later(() -> show(look, camera, photo));
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
     * interval has passed since its last picture, or if the frame is the frame of the last picture.
     */
    private void requireTurn(ClientMessage.Look look, Sensor camera, long frame) throws BadMessage {
        long last = lastFrames.getOrDefault(camera.name(), Long.MIN_VALUE / 2);
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

    private void show(ClientMessage.Look look, Sensor camera, Cameras.Photo photo) {
        try {
            requireTurn(look, camera, photo.frame());
            lastFrames.put(camera.name(), photo.frame());
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
