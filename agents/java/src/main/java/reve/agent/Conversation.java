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
 * What a client and a server have said to each other: one session, over however many connections.
 * No sockets, no threads: what is to be sent is returned as bytes, what has come is given to {@link
 * #take}. Who shares one holds a lock.
 */
final class Conversation {

    private static final long NO_FRAME = -1;

    private final Join join;
    private final Welcome welcome;
    private long lastId;
    private final Map<Long, Optional<ServerMessage>> answers = new HashMap<>();

    /** What is sent again after a break, in order. */
    private final Map<Long, byte[]> unanswered = new LinkedHashMap<>();

    /** Questions about frames that are not made yet. */
    private final Set<Long> ahead = new HashSet<>();

    /** The stream of perceptions; 0 if there is none. In lock-step it has no id. */
    private long subscription;

    private int every;
    private @Nullable Perception known;
    private @Nullable Perception latest;

    /** Acts of the round, in lock-step. */
    private List<Long> doing = List.of();

    private long readyFrame = NO_FRAME;
    private long observedFrame = NO_FRAME;
    private final Deque<WorldEvent> events = new ArrayDeque<>();
    private long frameSeen;

    /** Frames of the events that came after the last frame that was seen whole. */
    private final List<Long> seenAfter = new ArrayList<>();

    private int knownAlready;
    private long missedEvents;

    /** A message that is answered, as it is to be sent. */
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

    /** Asks what would be perceived that many frames from now. */
    Question fork(int frames) {
        Question question = question(id -> Protocol.command(id, "fork", Map.of("frames", frames)));
        ahead.add(question.id());
        return question;
    }

    boolean hasAnswer(long id) {
        return answers.get(id).isPresent();
    }

    /**
     * @throws AgentException with what the server refused
     */
    <T extends ServerMessage> T answer(long id, Class<T> type) {
        ServerMessage answer = answers.get(id).orElseThrow();
        if (answer instanceof ServerMessage.Error error) {
            throw AgentException.refused(error);
        }
        if (!type.isInstance(answer)) {
            throw AgentException.unexpected(answer);
        }
        return type.cast(answer);
    }

    /** Nobody waits for that answer any more. */
    void drop(long id) {
        answers.remove(id);
        unanswered.remove(id);
        ahead.remove(id);
    }

    byte[] encode(ObjectNode message) {
        return Wire.encode(message, join.encoding());
    }

    /** Begins another stream in place of the one there is, if any. */
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

    /** Longest time between two perceptions of the stream. */
    Duration pace() {
        return Duration.ofMillis(1000L * every / welcome.rate());
    }

    boolean hasNews() {
        return latest != null;
    }

    Perception news() {
        Perception perception = Objects.requireNonNull(latest);
        latest = null;
        return perception;
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

    /** Does these things and is done with the round. */
    byte[] ready(Act... acts) {
        OptionalLong seen = known == null ? OptionalLong.empty() : OptionalLong.of(known.frame());
        doing.forEach(this::drop);
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
        doing = ids;
        if (acts.length == 0) {
            lines.writeBytes(encode(Protocol.ready(seen)));
        }
        return lines.toByteArray();
    }

    /**
     * True if a perception of that frame or a later one was not looked at, and the results of what
     * was done are here.
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
        List<Long> ids = doing;
        doing = List.of();
        try {
            return seen.with(ids.stream().map(id -> answer(id, ActResult.class)).toList());
        } finally {
            ids.forEach(this::drop);
        }
    }

    /**
     * True if the round went on without us, and the next one waits while we still wait for results.
     */
    boolean mustSayReady() {
        return known != null && known.frame() > readyFrame && !isAllDone();
    }

    byte[] sayReady() {
        readyFrame = Objects.requireNonNull(known).frame();
        return encode(Protocol.ready(OptionalLong.of(readyFrame)));
    }

    private boolean isAllDone() {
        return doing.stream().allMatch(this::hasAnswer);
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
     * Something has come.
     *
     * @return what is to be said to it at once, if anything
     * @throws AgentException if the connection ends, or nobody asked for that
     */
    Optional<byte[]> take(ServerMessage message) {
        switch (message) {
            case ServerMessage.Ping ping -> {
                return Optional.of(encode(Protocol.pong()));
            }
            case ServerMessage.Bye bye ->
                    throw new DisconnectedException(bye.code(), bye.message(), bye.hint());
            case ServerMessage.Pong pong -> answer(pong.id(), pong);
            case ServerMessage.Error error -> {
                if (error.id().isEmpty()) {
                    throw AgentException.refused(error);
                }
                answer(error.id(), error);
            }
            case Image image -> answer(OptionalLong.of(image.id()), image);
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

    /** In lock-step perceptions come without having been asked for. */
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
        } else if (knownAlready > 0) { // told again after a break
            knownAlready--;
        } else {
            keep(event);
            hasSeen(event.frame() - 1);
            seenAfter.add(event.frame());
        }
    }

    /** The server did not send the events of some frames, up to that of the gap. */
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

    /** All events up to that frame have come. */
    private void hasSeen(long frame) {
        if (frame > frameSeen) {
            frameSeen = frame;
            seenAfter.removeIf(later -> later <= frame);
        }
    }

    /** How another connection goes on; empty where that is not possible. */
    Optional<Join> greeting() {
        return welcome.session()
                .map(
                        session ->
                                join.resuming(
                                        welcome.world(),
                                        new Join.Resume(session.token(), Math.max(0, frameSeen))));
    }

    /** Another connection has been welcomed: what has to be said again over it. */
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
