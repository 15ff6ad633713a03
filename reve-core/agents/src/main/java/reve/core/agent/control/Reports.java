// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import reve.core.agent.net.RateLimitedLog;
import reve.core.agent.port.WorldControl;
import reve.core.agent.port.WorldPort;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.ServerMessage;
import reve.core.agent.protocol.Text;
import reve.core.agent.publish.Publisher;
import reve.core.frame.FramePhase;
import reve.core.frame.FrameProfile;
import reve.core.frame.Pacing;
import reve.core.world.ActionRefused;
import reve.core.world.ItemSymbols;
import reve.core.world.WorldSnapshot;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.function.Supplier;

/**
 * Answers to queries about the state of the frame loop, the laws, the ledger of energy and
 * momentum, and the aspects of an item. Queries change nothing, and answers are not stored. For any
 * thread.
 */
final class Reports {

    /**
     * Maximum number of attempts to read an item. A further attempt is needed if the snapshot is
     * overwritten while it is read.
     */
    private static final int ATTEMPTS = 8;

    private final WorldPort port;
    private final Publisher publisher;
    private final Images images;
    private final RateLimitedLog log;
    private final SharedReports shared;

    Reports(
            WorldPort port,
            Publisher publisher,
            Images images,
            RateLimitedLog log,
            Supplier<List<Map<String, Object>>> clients) {
        this.port = port;
        this.publisher = publisher;
        this.images = images;
        this.log = log;
        long startNanos = System.nanoTime();
        this.shared =
                new SharedReports(
                        port,
                        publisher,
                        log,
                        Map.of(
                                SharedReports.Kind.STATE,
                                content -> {
                                    content.put("clients", clients.get());
                                    return content;
                                }),
                        () -> System.nanoTime() - startNanos);
    }

    /**
     * Answers waiting queries if the reports so far have not used up their share of time. Called
     * periodically.
     */
    void proceed() {
        shared.proceed();
    }

    void state(Requester requester, ClientMessage.State query) {
        shared.ask(requester, query, SharedReports.Kind.STATE, this::state);
    }

    void laws(Requester requester, ClientMessage.Laws query) {
        try {
            shared.ask(
                    requester,
                    query,
                    requester.controls()
                            ? SharedReports.Kind.LAWS_WITH_FAULTS
                            : SharedReports.Kind.LAWS,
                    port.control().laws(requester.controls()));
        } catch (ActionRefused e) {
            requester.refuse(query, e.code(), e.getMessage());
        }
    }

    void ledger(Requester requester, ClientMessage.Ledger query) {
        between(requester, query, () -> port.control().ledger(query.open()));
    }

    /**
     * Answers with the aspects of an item, read from the newest snapshot on the requester's thread.
     */
    void item(Requester requester, ClientMessage.Inspect query) {
        try {
            for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
                Optional<WorldSnapshot> newest = port.snapshots().acquireLatest();
                if (newest.isEmpty()) {
                    break;
                }
                try (WorldSnapshot snapshot = newest.get()) {
                    ItemSymbols item = find(snapshot, query.item());
                    Map<String, Object> content = ItemReport.of(snapshot, item);
                    if (!snapshot.lost()) {
                        answer(requester, query, snapshot.frame(), content);
                        return;
                    }
                } catch (IllegalArgumentException | IndexOutOfBoundsException lost) {
                    log.warn(() -> "an item was read from a lost snapshot: " + lost.getMessage());
                }
            }
            requester.refuse(
                    query, "world-busy", "the world has no frame that can be read; try again");
        } catch (ActionRefused e) {
            requester.refuse(query, e.code(), e.getMessage());
        }
    }

    private static ItemSymbols find(WorldSnapshot snapshot, String name) throws ActionRefused {
        for (ItemSymbols item : snapshot.symbols().values()) {
            if (item.name().equals(name)) {
                return item;
            }
        }
        throw new ActionRefused("no-such-item", "the world has no item " + Text.quote(name));
    }

    private void between(
            Requester requester, ClientMessage.Request query, WorldControl.Reading reading) {
        port.loop()
                .betweenFrames(
                        () -> {
                            long frame = port.loop().frame();
                            try {
                                Map<String, Object> content = reading.read();
                                publisher.later(() -> answer(requester, query, frame, content));
                            } catch (ActionRefused e) {
                                publisher.later(
                                        () -> requester.refuse(query, e.code(), e.getMessage()));
                            } catch (RuntimeException e) {
                                publisher.later(() -> fail(requester, query, log, e));
                            }
                        });
    }

    static void fail(
            Requester requester,
            ClientMessage.Request query,
            RateLimitedLog log,
            Exception failure) {
        log.error(query.type() + " failed", failure);
        requester.refuse(
                query, "action-failed", query.type() + " failed; the server's log says why");
    }

    private static void answer(
            Requester requester,
            ClientMessage.Request query,
            long frame,
            Map<String, Object> content) {
        answer(
                requester,
                query,
                new ServerMessage.Report(query.id(), frame, query.type(), content)
                        .in(requester.encoding()));
    }

    static void answer(Requester requester, ClientMessage.Request query, byte[] line) {
        if (!requester.answer(query, line)) {
            requester.refuse(
                    query,
                    "too-large",
                    "the report has " + line.length + " bytes, which is more than is sent at once");
        }
    }

    private Map<String, Object> state() {
        FrameProfile profile = port.loop().profile();
        var content = new LinkedHashMap<String, Object>();
        content.put("paused", port.loop().isPaused());
        content.put("fast", port.loop().pacing() == Pacing.FAST);
        content.put("rate", port.framesPerSecond());
        content.put("speed", port.loop().speed());
        content.put("frames", profile.frames());
        content.put("overruns", profile.overruns());
        content.put("droppedFrames", profile.droppedFrames());
        content.put("busySeconds", profile.busyNanoseconds() / 1e9);
        var phases = new LinkedHashMap<String, Object>();
        for (FramePhase phase : FramePhase.values()) {
            phases.put(
                    phase.name().toLowerCase(Locale.ROOT),
                    profile.phaseNanoseconds().getOrDefault(phase, 0L) / 1e9);
        }
        content.put("phaseSeconds", phases);
        content.put("images", images.names());
        return content;
    }
}
