// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.audit;

import reve.core.text.Visible;

import java.time.Instant;
import java.util.ArrayDeque;
import java.util.Comparator;
import java.util.Deque;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.regex.Matcher;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/**
 * The newest records of an audit log, kept in memory. Messages of types that clients receive often,
 * such as perceptions, do not displace the other messages. For any thread.
 */
final class RecentRecords {

    /** Number of records of frequent messages, and of other messages, that are kept for a world. */
    static final int MOST = 250;

    /** Length of the kept part of a message [characters]. */
    static final int MOST_CHARACTERS = 600;

    /** Number of worlds whose records are kept. */
    private static final int MOST_WORLDS = 64;

    private static final Set<String> FREQUENT = Set.of("perception", "report", "ping", "pong");
    private static final Pattern TYPE = Pattern.compile("\\{\"t\":\"([a-z-]{1,32})\"");

    /** The newest records of a world. Numbers count the records of this world only. */
    private static final class Kept {
        private final Deque<AuditRecord> frequent = new ArrayDeque<>();
        private final Deque<AuditRecord> others = new ArrayDeque<>();
        private long count;
    }

    /** The records by world. The world whose last record is the oldest comes first. */
    private final Map<String, Kept> byWorld = new LinkedHashMap<>();

    /**
     * Adds a record.
     *
     * @param json the message without secrets
     */
    synchronized void add(Instant at, String world, String client, String json) {
        Kept kept = byWorld.remove(world);
        if (kept == null) {
            kept = new Kept();
        }
        byWorld.put(world, kept); // as the newest
        if (byWorld.size() > MOST_WORLDS) {
            byWorld.remove(byWorld.keySet().iterator().next());
        }
        Matcher start = TYPE.matcher(json);
        String type = start.lookingAt() ? start.group(1) : "";
        Deque<AuditRecord> records = FREQUENT.contains(type) ? kept.frequent : kept.others;
        if (records.size() == MOST) {
            records.removeFirst();
        }
        records.addLast(
                new AuditRecord(++kept.count, at, client, type, beginning(json), json.length()));
    }

    /** Returns the beginning of a message, with escapes for invisible characters. */
    private static String beginning(String json) {
        return cut(Visible.json(cut(json)));
    }

    private static String cut(String text) {
        if (text.length() <= MOST_CHARACTERS) {
            return text;
        }
        int end =
                Character.isHighSurrogate(text.charAt(MOST_CHARACTERS - 1))
                        ? MOST_CHARACTERS - 1
                        : MOST_CHARACTERS;
        return text.substring(0, end);
    }

    /**
     * Returns the newest records of a world, the newest first.
     *
     * @param client the client whose records are returned; empty for all clients
     * @param frequent whether messages of frequent types are returned, too
     */
    synchronized List<AuditRecord> newest(
            String world, Optional<String> client, boolean frequent, int most) {
        Kept kept = byWorld.get(world);
        if (kept == null) {
            return List.of();
        }
        Stream<AuditRecord> records = kept.others.stream();
        return (frequent ? Stream.concat(kept.frequent.stream(), records) : records)
                .filter(record -> client.isEmpty() || client.get().equals(record.client()))
                .sorted(Comparator.comparingLong(AuditRecord::number).reversed())
                .limit(most)
                .toList();
    }
}
