package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.List;
import org.junit.jupiter.api.Test;

/** The order in which one client is told things. */
class OutboxTest {

    private final Outbox outbox = new Outbox(2, 100, () -> { });

    @Test
    void whatHappenedComesBeforeThePerceptionsThatShowIt() {
        outbox.offerLatest(perception("latest"), view(1), null);
        outbox.offerAnswer(perception("answer"));
        outbox.offer(bytes("event"));
        assertThat(List.of(take(), take(), take())).containsExactly("event", "answer", "latest");
        assertThat(outbox.isEmpty()).isTrue();
    }

    @Test
    void whatHappenedComesBeforeThePerceptionAlsoWhenTheConnectionEnds() {
        outbox.offer(bytes("result"));
        outbox.offer(bytes("event"));
        outbox.offerAnswer(perception("answer"));
        outbox.offerLatest(perception("latest"), view(1), null);
        outbox.finish(bytes("bye"));
        outbox.offer(bytes("too late"));
        var told = new ArrayList<String>();
        for (String line = take(); line != null; line = take()) {
            told.add(line);
        }
        assertThat(told).containsExactly("result", "event", "answer", "bye");
    }

    @Test
    void whatWasWrittenMakesRoomForMore() {
        for (int i = 0; i < 10; i++) {
            assertThat(outbox.offer(new byte[50])).isTrue();
            assertThat(outbox.offer(new byte[50])).isTrue();
            assertThat(outbox.offer(new byte[0])).as("a third message").isFalse();
            outbox.poll(Integer.MAX_VALUE);
            assertThat(outbox.offer(new byte[51])).as("101 bytes").isFalse();
            outbox.poll(Integer.MAX_VALUE);
        }
    }

    @Test
    void aDifferenceIsTakenOnlyToWhatTheClientWasHandedLast() {
        View first = view(1);
        assertThat(outbox.offerLatest(perception("first"), first, null)).isTrue();
        assertThat(outbox.offerLatest(perception("second"), view(2), null)).as("nobody has read the first").isTrue();
        take();
        assertThat(outbox.told()).isEqualTo(view(2));
        assertThat(outbox.offerLatest(perception("third"), view(3), first)).isFalse();
        assertThat(outbox.offerLatest(perception("third"), view(3), outbox.told())).isTrue();
        outbox.restart();
        assertThat(outbox.isEmpty()).isTrue();
        assertThat(outbox.told()).isNull();
    }

    private static View view(long frame) {
        return new View(frame, 0, List.of());
    }

    private String take() {
        Outbox.Line line = outbox.poll(Integer.MAX_VALUE);
        return line == null ? null : text(line.head()) + text(line.tail());
    }

    private static Outbox.Line perception(String text) {
        return new Outbox.Line(bytes(text.substring(0, 3)), bytes(text.substring(3)));
    }

    private static byte[] bytes(String text) {
        return text.getBytes(StandardCharsets.UTF_8);
    }

    private static String text(byte[] bytes) {
        return new String(bytes, StandardCharsets.UTF_8);
    }
}
