// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import org.jspecify.annotations.Nullable;

import reve.core.agent.audit.AuditLog;
import reve.core.agent.audit.AuditRecord;
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
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.atomic.AtomicLong;

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

    /** Maximum length of the text of a query that waits for its turn. */
    private static final int LONGEST_TEXT = 1000;

    private final WorldPort port;
    private final Publisher publisher;
    private final Images images;
    private final RateLimitedLog log;
    private final SharedReports shared;
    private final QueryTurns turns;
    private final ColumnReadings columns;
    private final Clients clients;
    private final Optional<AuditLog> audit;

    /** Number of the newest frame that contains a change which was made between frames. */
    private final AtomicLong changed = new AtomicLong();

    Reports(
            WorldPort port,
            Publisher publisher,
            Images images,
            RateLimitedLog log,
            Clients clients,
            Optional<AuditLog> audit) {
        this.port = port;
        this.publisher = publisher;
        this.images = images;
        this.log = log;
        this.clients = clients;
        this.audit = audit;
        long startNanos = System.nanoTime();
        this.shared =
                new SharedReports(
                        port,
                        publisher,
                        log,
                        Map.of(
                                SharedReports.Kind.STATE,
                                content -> {
                                    content.put("clients", clients.describe());
                                    return content;
                                }),
                        () -> System.nanoTime() - startNanos);
        this.turns =
                new QueryTurns(
                        publisher::later, () -> System.nanoTime() - startNanos, this::isReadable);
        this.columns =
                new ColumnReadings(
                        port.loop()::betweenFrames,
                        publisher::later,
                        this::lawColumns,
                        this::item,
                        () -> System.nanoTime() - startNanos);
    }

    /**
     * Answers waiting queries if the reports so far have not used up their share of time. Called
     * periodically.
     */
    void proceed() {
        shared.proceed();
        columns.proceed();
        turns.proceed();
    }

    void state(Requester requester, ClientMessage.State query) {
        if (query.roundTrips()) {
            if (!requester.controls()) {
                requester.refuse(
                        query,
                        "not-permitted",
                        "state with roundTrips sends a ping to every client, and takes the role"
                                + " control; leave roundTrips out");
                return;
            }
            publisher.later(clients::measureRoundTrips);
        }
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

    /** Drops the waiting queries of a client that has no connection any more. */
    void forget(Requester requester) {
        shared.forget(requester);
        columns.forget(requester);
        turns.forget(requester);
    }

    /**
     * Reports that a change was made between two frames. A query that arrives later is answered
     * from a frame that contains the change.
     *
     * @param frame number of the frame that contains the change first
     */
    void changed(long frame) {
        changed.accumulateAndGet(frame, Math::max);
    }

    /** Returns whether queries can read a frame, or the world makes no frames now. */
    private boolean isReadable(long frame) {
        if (port.loop().isPaused() || port.loop().isStopped()) {
            return true;
        }
        try (WorldSnapshot snapshot = port.snapshots().acquireLatest().orElse(null)) {
            return snapshot == null || frame <= snapshot.frame();
        }
    }

    /** Queues a query for its turn, unless its text is too long. */
    private void ask(
            Requester requester, ClientMessage.Query query, String text, QueryTurns.Work work) {
        if (isShort(requester, query, text)) {
            turns.ask(requester, query, changed.get(), work);
        }
    }

    /** Returns whether the text of a query is short enough; refuses the query otherwise. */
    private static boolean isShort(Requester requester, ClientMessage.Query query, String text) {
        if (text.length() <= LONGEST_TEXT) {
            return true;
        }
        requester.refuse(
                query,
                "too-large",
                "the text has "
                        + text.length()
                        + " characters, at most "
                        + LONGEST_TEXT
                        + " are allowed");
        return false;
    }

    /**
     * Answers with the aspects of an item, read from the newest snapshot, and with the columns that
     * laws have of their own.
     */
    void item(Requester requester, ClientMessage.Inspect query) {
        if (isShort(requester, query, query.item())) {
            columns.ask(requester, query);
        }
    }

    /** Returns the fields of laws' own columns. For the world's thread, between two frames. */
    private Map<String, Object> lawColumns(String item) {
        try {
            return port.control().lawColumns(item);
        } catch (RuntimeException e) {
            log.error("the columns of laws cannot be read", e);
            return Map.of();
        }
    }

    private void item(
            Requester requester, ClientMessage.Inspect query, Map<String, Object> lawColumns) {
        turns.ask(
                requester,
                query,
                changed.get(),
                end -> {
                    readItem(requester, query, lawColumns);
                    return true;
                });
    }

    private void readItem(
            Requester requester, ClientMessage.Inspect query, Map<String, Object> lawColumns) {
        try {
            for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
                Optional<WorldSnapshot> newest = port.snapshots().acquireLatest();
                if (newest.isEmpty()) {
                    break;
                }
                try (WorldSnapshot snapshot = newest.get()) {
                    ItemSymbols item = find(snapshot, query.item());
                    Map<String, Object> content = ItemReport.of(snapshot, item);
                    content.putAll(lawColumns);
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

    /** Answers with the items whose names or symbols contain a text. */
    void search(Requester requester, ClientMessage.Search query) {
        ask(requester, query, query.text(), new Search(requester, query));
    }

    /** A search in the newest frame at its first turn. */
    private final class Search implements QueryTurns.Work {
        private final Requester requester;
        private final ClientMessage.Search query;
        private long frame;
        private @Nullable ItemSearch search;

        Search(Requester requester, ClientMessage.Search query) {
            this.requester = requester;
            this.query = query;
        }

        @Override
        public boolean proceed(long end) {
            ItemSearch items = search == null ? begin() : search;
            if (items == null) {
                requester.refuse(query, "world-busy", "the world has no frame yet; try again");
                return true;
            }
            search = items;
            boolean isDone = !items.step();
            while (!isDone && turns.now() < end) {
                isDone = !items.step();
            }
            if (isDone) {
                answer(requester, query, frame, items.result());
            }
            return isDone;
        }

        private @Nullable ItemSearch begin() {
            try (WorldSnapshot snapshot = port.snapshots().acquireLatest().orElse(null)) {
                if (snapshot == null) {
                    return null;
                }
                frame = snapshot.frame();
                return new ItemSearch(snapshot.symbols().values(), query.text());
            }
        }
    }

    /** Answers with what an agent perceived last. */
    void perceived(Requester requester, ClientMessage.Perceived query) {
        ask(
                requester,
                query,
                query.client(),
                end -> {
                    Optional<Map<String, Object>> content = clients.perceived(query.client());
                    if (content.isPresent()) {
                        answer(requester, query, publisher.published(), content.get());
                    } else {
                        requester.refuse(
                                query,
                                "no-such-agent",
                                "the world has no agent " + Text.quote(query.client()));
                    }
                    return true;
                });
    }

    /** Answers with the newest records of the audit log about this world. */
    void audit(Requester requester, ClientMessage.Audit query) {
        if (audit.isEmpty()) {
            requester.refuse(
                    query,
                    "unsupported",
                    "this server keeps no audit record; serve --audit FILE keeps one");
            return;
        }
        var content = new LinkedHashMap<String, Object>();
        content.put("unrecorded", audit.get().unrecorded());
        content.put(
                "records",
                audit
                        .get()
                        .newest(port.world(), query.client(), query.frequent(), query.most())
                        .stream()
                        .map(Reports::describe)
                        .toList());
        answer(requester, query, port.loop().frame(), content);
    }

    private static Map<String, Object> describe(AuditRecord record) {
        var fields = new LinkedHashMap<String, Object>();
        fields.put("number", record.number());
        fields.put("at", record.at().toString());
        fields.put("client", record.client());
        fields.put("type", record.type());
        fields.put("message", record.message());
        if (record.isCut()) {
            fields.put("length", record.length());
        }
        return fields;
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
