// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import reve.core.agent.embodiment.Embodiment;
import reve.core.agent.net.RateLimitedLog;
import reve.core.agent.perception.Difference;
import reve.core.agent.perception.Observatory;
import reve.core.agent.perception.PerceptionEncoder;
import reve.core.agent.perception.View;
import reve.core.agent.port.WorldControl;
import reve.core.agent.port.WorldPort;
import reve.core.agent.protocol.Bytes;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.ServerMessage;
import reve.core.world.ActionRefused;
import reve.core.world.ItemId;

import java.util.List;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.ExecutionException;
import java.util.concurrent.Semaphore;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.TimeoutException;
import java.util.concurrent.atomic.AtomicReference;

/**
 * Commands that work on a copy of a world while the world continues: saving the copy as a file, and
 * advancing it (fork). Only one such command runs at a time, on the requester's thread.
 */
final class ForkAndSave {

    /**
     * Maximum time that a command waits for a moment between two frames in which the world can be
     * copied [s].
     */
    private static final long PATIENCE_SECONDS = 10;

    private final WorldPort port;
    private final Embodiment embodiment;
    private final RateLimitedLog log;
    private final Semaphore copies = new Semaphore(1);

    /**
     * The state of the world at one moment.
     *
     * @param made bodies that were created for agents
     */
    private record Now(WorldControl.Image image, long frame, List<ItemId> made) {}

    private interface Study {
        void run(Now now) throws ActionRefused;
    }

    ForkAndSave(WorldPort port, Embodiment embodiment, RateLimitedLog log) {
        this.port = port;
        this.embodiment = embodiment;
        this.log = log;
    }

    void save(Requester requester, ClientMessage.Save save) {
        study(
                requester,
                save,
                now -> {
                    now.image.save(save.file(), now.made);
                    requester.finish(
                            save, new ServerMessage.Accepted(save.id(), now.frame), now.frame);
                });
    }

    /**
     * Advances a copy of the world, and reports its state.
     *
     * @param first the change that is made in the copy before its first frame
     */
    void fork(Requester requester, ClientMessage.Fork fork, WorldControl.Change first) {
        study(
                requester,
                fork,
                now -> {
                    var line = new AtomicReference<byte[]>();
                    now.image.foresee(
                            fork.frames(),
                            first,
                            snapshot -> {
                                var observatory = new Observatory();
                                observatory.read(snapshot);
                                var out = new Bytes();
                                View all = observatory.everything();
                                new PerceptionEncoder()
                                        .write(
                                                out,
                                                new Difference(),
                                                requester.encoding(),
                                                fork.id(),
                                                all,
                                                null);
                                line.set(out.toArray());
                            });
                    if (!requester.answer(fork, line.get())) {
                        throw new ActionRefused(
                                "fork-refused",
                                "the perception has "
                                        + line.get().length
                                        + " bytes, which is more than is sent at once");
                    }
                });
    }

    private void study(Requester requester, ClientMessage.Request request, Study study) {
        if (!copies.tryAcquire()) {
            requester.refuse(
                    request, "world-busy", "another copy of the world is at work; try again");
            return;
        }
        try {
            Now now = copy();
            try (WorldControl.Image _ = now.image) {
                study.run(now);
            }
        } catch (ActionRefused e) {
            requester.refuse(request, e.code(), e.getMessage());
        } catch (PerceptionEncoder.TooLarge e) {
            requester.refuse(request, "too-large", e.getMessage());
        } catch (RuntimeException e) {
            log.error(request.type() + " failed", e);
            requester.refuse(
                    request,
                    "action-failed",
                    request.type() + " failed; the server's log says why");
        } finally {
            copies.release();
        }
    }

    private Now copy() throws ActionRefused {
        var copied = new CompletableFuture<Now>();
        port.loop()
                .betweenFrames(
                        () -> {
                            try {
                                var now =
                                        new Now(
                                                port.control().keep(),
                                                port.loop().frame(),
                                                embodiment.made());
                                if (!copied.complete(now)) {
                                    now.image.close();
                                }
                            } catch (ActionRefused | RuntimeException e) {
                                copied.completeExceptionally(e);
                            }
                        });
        try {
            return copied.get(PATIENCE_SECONDS, TimeUnit.SECONDS);
        } catch (ExecutionException e) {
            if (e.getCause() instanceof ActionRefused refused) {
                throw refused;
            }
            throw new IllegalStateException("the world could not be copied", e.getCause());
        } catch (TimeoutException | InterruptedException e) {
            copied.cancel(false);
            throw new ActionRefused(
                    "world-busy",
                    "the world had no moment between frames within " + PATIENCE_SECONDS + " s");
        }
    }
}
