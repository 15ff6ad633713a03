// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import org.jspecify.annotations.Nullable;

import tools.jackson.databind.node.ObjectNode;

import java.io.ByteArrayOutputStream;
import java.time.Duration;
import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Deque;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.OptionalLong;
import java.util.Set;
import java.util.function.LongFunction;

/**
 * The state of one session, over one or several connections. It has no sockets and no threads.
 * Methods return the bytes to send, and {@link #take} receives messages. Threads that share an
 * object of this class need a lock.
 */
final class Conversation {

    private static final long NO_FRAME = -1;

    private final Join join;
    private final Welcome welcome;
    private long lastId;
    private final Map<Long, Optional<ServerMessage>> answers = new HashMap<>();

    /** Requests that have no answer yet, in order. They are sent again after a reconnection. */
    private final Map<Long, byte[]> unanswered = new LinkedHashMap<>();

    /** Ids of requests for the perception of a future frame, which {@link #fork} sent. */
    private final Set<Long> ahead = new HashSet<>();

    /**
     * Id of the stream of perceptions; 0 if there is none. The stream of an agent in lock-step has
     * no id.
     */
    private long subscription;

    private int every;
    private @Nullable Perception known;
    private @Nullable Perception latest;

    /** Ids of this agent's acts in the current round of lock-step. */
    private List<Long> roundActs = List.of();

    private long readyFrame = NO_FRAME;
    private long observedFrame = NO_FRAME;
    private final Deque<WorldEvent> events = new ArrayDeque<>();

    /** Texts that the agent has heard and that were not yet returned with a perception. */
    private final Deque<Heard> heard = new ArrayDeque<>();

    private long frameSeen;

    /**
     * Frame numbers of received events that are later than {@link #frameSeen}. All events up to the
     * frame {@code frameSeen} have arrived.
     */
    private final List<Long> seenAfter = new ArrayList<>();

    private int knownAlready;
    private long missedEvents;

    /** A message that has an answer, in encoded form. */
    record Question(long id, byte[] line) {}

    Conversation(Join join, Welcome welcome) {
        this.join = join;
        this.welcome = welcome;
        this.frameSeen = join.resume().map(Join.Resume::frame).orElse(welcome.frame() - 1);
    }

    Welcome welcome() {
        return welcome;
    }

    Question question(LongFunction<ObjectNode> build) {
        long id = ++lastId;
        byte[] line = encode(build.apply(id));
        answers.put(id, Optional.empty());
        unanswered.put(id, line);
        return new Question(id, line);
    }

    /** Requests the perception of a copy of the world after {@code frames} more frames. */
    Question fork(int frames, List<? extends Map<String, ?>> changes) {
        Map<String, ?> fields =
                changes.isEmpty()
                        ? Map.of("frames", frames)
                        : Map.of("frames", frames, "changes", changes);
        Question question = question(id -> Protocol.command(id, "fork", fields));
        ahead.add(question.id());
        return question;
    }

    boolean hasAnswer(long id) {
        return answers.get(id).isPresent();
    }

    /**
     * Returns the answer to a request.
     *
     * @throws AgentException if the server refused the request
     */
    <T extends ServerMessage> T answer(long id, Class<T> type) {
        ServerMessage answer = answers.get(id).orElseThrow();
        if (answer instanceof ServerMessage.Error error) {
            throw AgentException.refused(error);
        }
        if (answer instanceof Perception perception && !ahead.contains(id)) {
            answer = withHeard(perception);
        }
        if (!type.isInstance(answer)) {
            throw AgentException.unexpected(answer);
        }
        return type.cast(answer);
    }

    /** Adds the texts that were heard up to the frame of the perception and not returned yet. */
    private Perception withHeard(Perception perception) {
        var voices = new ArrayList<Heard>();
        while (!heard.isEmpty() && heard.getFirst().frame() <= perception.frame()) {
            voices.add(heard.removeFirst());
        }
        return perception.withHeard(List.copyOf(voices));
    }

    /** Removes a request, so that its answer is ignored. */
    void drop(long id) {
        answers.remove(id);
        unanswered.remove(id);
        ahead.remove(id);
    }

    byte[] encode(ObjectNode message) {
        return Wire.encode(message, join.encoding());
    }

    /** Begins a stream of perceptions, which replaces the present stream. */
    byte[] subscribe(int frames) {
        subscription = ++lastId;
        every = frames;
        known = null;
        latest = null;
        return encode(Protocol.perceive(subscription, frames));
    }

    boolean isSubscribed() {
        return subscription != 0;
    }

    /** Returns the maximum time between two perceptions of the stream. */
    Duration pace() {
        return Duration.ofMillis(1000L * every / welcome.rate());
    }

    boolean hasNews() {
        return latest != null;
    }

    Perception news() {
        Perception perception = Objects.requireNonNull(latest);
        latest = null;
        return withHeard(perception);
    }

    Optional<byte[]> unsubscribe() {
        if (!isSubscribed()) {
            return Optional.empty();
        }
        subscription = 0;
        known = null;
        latest = null;
        return Optional.of(encode(Protocol.perceive(++lastId, 0)));
    }

    /** Performs acts and ends the round. */
    byte[] ready(Act... acts) {
        OptionalLong seen = known == null ? OptionalLong.empty() : OptionalLong.of(known.frame());
        roundActs.forEach(this::drop);
        readyFrame = seen.orElse(NO_FRAME);
        var lines = new ByteArrayOutputStream();
        var ids = new ArrayList<Long>();
        for (int i = 0; i < acts.length; i++) {
            Act act = acts[i];
            String item = act.item().orElseGet(() -> welcome.body().orElseThrow());
            boolean last = i == acts.length - 1;
            Question question =
                    question(
                            id -> {
                                ObjectNode message =
                                        Protocol.act(id, item, act.action(), act.arguments());
                                return last ? Protocol.andReady(message, seen) : message;
                            });
            ids.add(question.id());
            lines.writeBytes(question.line());
        }
        roundActs = ids;
        if (acts.length == 0) {
            lines.writeBytes(encode(Protocol.ready(seen)));
        }
        return lines.toByteArray();
    }

    /**
     * Returns whether a perception of the given frame or a later one is available, together with
     * the results of the round's acts.
     */
    boolean hasObservation(long frame) {
        return known != null
                && known.frame() > observedFrame
                && known.frame() >= frame
                && isAllDone();
    }

    Perception observation() {
        Perception seen = Objects.requireNonNull(known);
        observedFrame = seen.frame();
        List<Long> ids = roundActs;
        roundActs = List.of();
        try {
            return withHeard(seen)
                    .with(ids.stream().map(id -> answer(id, ActResult.class)).toList());
        } finally {
            ids.forEach(this::drop);
        }
    }

    /**
     * Returns whether the client must send {@code ready} without acts. This is necessary if a round
     * ended without this agent. The world waits for the agent in the next round, while the agent
     * still waits for results of its acts.
     */
    boolean mustSayReady() {
        return known != null && known.frame() > readyFrame && !isAllDone();
    }

    byte[] sayReady() {
        readyFrame = Objects.requireNonNull(known).frame();
        return encode(Protocol.ready(OptionalLong.of(readyFrame)));
    }

    private boolean isAllDone() {
        return roundActs.stream().allMatch(this::hasAnswer);
    }

    long missedEvents() {
        return missedEvents;
    }

    List<WorldEvent> events() {
        List<WorldEvent> news = List.copyOf(events);
        events.clear();
        return news;
    }

    /**
     * Processes a message.
     *
     * @return an immediate reply, if any
     * @throws AgentException if the connection ends, or the message answers no request
     */
    Optional<byte[]> take(ServerMessage message) {
        switch (message) {
            case ServerMessage.Ping ping -> {
                return Optional.of(encode(Protocol.pong()));
            }
            case ServerMessage.Bye bye -> throw DisconnectedException.of(bye);
            case ServerMessage.Pong pong -> answer(pong.id(), pong);
            case ServerMessage.Error error -> {
                if (error.id().isEmpty()) {
                    throw AgentException.refused(error);
                }
                answer(error.id(), error);
            }
            case Image image -> answer(OptionalLong.of(image.id()), image);
            case Report report -> answer(OptionalLong.of(report.id()), report);
            case ActResult result -> answer(OptionalLong.of(result.id()), result);
            case Perception perception -> perceive(perception);
            case Update update -> perceive(update);
            case WorldEvent event -> hear(event);
            case Welcome again -> throw AgentException.unexpected(again);
        }
        return Optional.empty();
    }

    private void perceive(Perception perception) {
        if (perception.id().equals(stream())) {
            show(perception);
        } else {
            if (perception.id().isEmpty() || !ahead.contains(perception.id().getAsLong())) {
                hasSeen(perception.frame());
            }
            answer(perception.id(), perception);
        }
    }

    private void perceive(Update update) {
        if (known != null && update.id().equals(stream())) {
            show(known.updated(update));
        }
    }

    private void show(Perception perception) {
        known = perception;
        latest = perception;
        hasSeen(perception.frame());
    }

    /**
     * Returns the id of the stream; empty in lock-step, where perceptions arrive without a request.
     */
    private OptionalLong stream() {
        return welcome.lockStep().isPresent()
                ? OptionalLong.empty()
                : OptionalLong.of(subscription);
    }

    private void answer(OptionalLong id, ServerMessage message) {
        if (id.isPresent()) {
            answers.computeIfPresent(id.getAsLong(), (number, none) -> Optional.of(message));
            unanswered.remove(id.getAsLong());
        }
    }

    private void hear(WorldEvent event) {
        if (event.type().equals(WorldEvent.MISSED)) {
            miss(event);
        } else if (knownAlready > 0) {
            // The server has sent this event again after a reconnection, so it is ignored.
            knownAlready--;
        } else {
            keep(event);
            if (event.type().equals(Heard.TYPE)) {
                if (heard.size() == AgentClient.MAX_EVENTS) {
                    heard.removeFirst();
                }
                heard.addLast(Heard.in(event));
            }
            hasSeen(event.frame() - 1);
            seenAfter.add(event.frame());
        }
    }

    /**
     * Stores the event {@code gap}, which represents events that the server did not send, and
     * counts these events.
     */
    private void miss(WorldEvent gap) {
        keep(gap);
        missedEvents += gap.fields().get("events") instanceof Double count ? count.longValue() : 1;
        hasSeen(gap.frame());
        knownAlready = Math.min(knownAlready, seenAfter.size());
    }

    private void keep(WorldEvent event) {
        if (events.size() == AgentClient.MAX_EVENTS) {
            events.removeFirst();
        }
        events.addLast(event);
    }

    /** Records that all events up to the given frame have arrived. */
    private void hasSeen(long frame) {
        if (frame > frameSeen) {
            frameSeen = frame;
            seenAfter.removeIf(later -> later <= frame);
        }
    }

    /** Returns the join that resumes the session; empty if that is not possible. */
    Optional<Join> greeting() {
        return welcome.session()
                .map(
                        session ->
                                join.resuming(
                                        welcome.world(),
                                        new Join.Resume(session.token(), Math.max(0, frameSeen))));
    }

    /**
     * Records the reconnection.
     *
     * @return the requests to send again
     */
    byte[] goneOn() {
        knownAlready = seenAfter.size();
        var lines = new ByteArrayOutputStream();
        unanswered.values().forEach(lines::writeBytes);
        if (isSubscribed()) {
            lines.writeBytes(encode(Protocol.perceive(subscription, every)));
        }
        return lines.toByteArray();
    }
}
