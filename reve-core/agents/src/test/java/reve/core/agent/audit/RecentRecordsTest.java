// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.audit;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import java.time.Instant;
import java.util.List;
import java.util.Optional;

class RecentRecordsTest {
    private final RecentRecords records = new RecentRecords();

    private void add(String world, String client, String type) {
        add(world, client, type, "");
    }

    private void add(String world, String client, String type, String rest) {
        records.add(
                Instant.parse("2030-01-01T00:00:00Z"),
                world,
                client,
                "{\"t\":\"" + type + "\"" + rest + "}");
    }

    private List<String> types(String world, Optional<String> client, int most) {
        return records.newest(world, client, true, most).stream().map(AuditRecord::type).toList();
    }

    @Test
    void theNewestRecordsOfAWorldComeFirst() {
        add("pond", "ada", "welcome");
        add("lake", "eve", "bye");
        add("pond", "bob", "event");
        add("pond", "ada", "result");

        assertThat(types("pond", Optional.empty(), 9))
                .containsExactly("result", "event", "welcome");
        assertThat(types("pond", Optional.empty(), 2)).containsExactly("result", "event");
        assertThat(types("pond", Optional.of("ada"), 9)).containsExactly("result", "welcome");
        assertThat(types("lake", Optional.empty(), 9)).containsExactly("bye");
        assertThat(types("lake", Optional.of("ada"), 9)).isEmpty();
        assertThat(types("sea", Optional.empty(), 9)).isEmpty();
        assertThat(records.newest("pond", Optional.empty(), true, 9))
                .extracting(AuditRecord::number)
                .containsExactly(3L, 2L, 1L);
    }

    @Test
    void perceptionsDoNotDisplaceOtherMessages() {
        add("pond", "ada", "welcome");
        for (int i = 0; i < 3 * RecentRecords.MOST; i++) {
            add("pond", "ada", "perception");
        }
        List<String> types = types("pond", Optional.empty(), Integer.MAX_VALUE);
        assertThat(types).hasSize(RecentRecords.MOST + 1).endsWith("welcome");
        assertThat(records.newest("pond", Optional.empty(), false, 9))
                .extracting(AuditRecord::type)
                .containsExactly("welcome");
        for (int i = 0; i < RecentRecords.MOST; i++) {
            add("pond", "ada", "event");
        }
        types = types("pond", Optional.empty(), Integer.MAX_VALUE);
        assertThat(types).hasSize(2 * RecentRecords.MOST).doesNotContain("welcome");
    }

    @Test
    void aLongMessageIsCutBetweenCharactersAndInvisibleOnesAreEscaped() {
        String begin = "{\"t\":\"event\",\"text\":\"";
        int room = RecentRecords.MOST_CHARACTERS - begin.length();
        add("pond", "ada", "event", ",\"text\":\"" + "x".repeat(room - 1) + "🦆".repeat(50) + "\"");
        AuditRecord cut = records.newest("pond", Optional.empty(), true, 1).getFirst();
        assertThat(cut.message()).isEqualTo(begin + "x".repeat(room - 1));
        assertThat(cut.isCut()).isTrue();
        assertThat(cut.length()).isEqualTo(begin.length() + room - 1 + 100 + 2);

        add("pond", "ada", "event", ",\"text\":\"\u202Eabc\"");
        AuditRecord escaped = records.newest("pond", Optional.empty(), true, 1).getFirst();
        assertThat(escaped.message()).isEqualTo(begin + "\\u202eabc\"}");
        assertThat(escaped.isCut()).isFalse();

        add("pond", "ada", "event", ",\"text\":\"" + "\u202E".repeat(900) + "\"");
        AuditRecord longest = records.newest("pond", Optional.empty(), true, 1).getFirst();
        assertThat(longest.message()).hasSize(RecentRecords.MOST_CHARACTERS);
    }

    @Test
    void theRecordsOfWorldsThatAreSilentForLongAreForgotten() {
        add("first", "ada", "welcome");
        add("second", "ada", "welcome");
        for (int world = 0; world < 63; world++) {
            add("world" + world, "ada", "welcome");
            add("second", "ada", "event");
        }
        assertThat(types("first", Optional.empty(), 9)).isEmpty();
        assertThat(types("second", Optional.empty(), 1)).containsExactly("event");
        assertThat(types("world0", Optional.empty(), 9)).containsExactly("welcome");
    }
}
