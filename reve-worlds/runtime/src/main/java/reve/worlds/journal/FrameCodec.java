// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.file.RuleChanges;
import reve.core.image.ChangeCodec;
import reve.core.image.CorruptException;
import reve.core.image.Trees;
import reve.core.world.ItemId;
import reve.core.world.WorldEvent;
import reve.pe.adapter.LawChange;

import tools.jackson.databind.JsonNode;

import java.nio.ByteBuffer;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Base64;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.function.Function;

/**
 * The codec of a journal's frames as JSON.
 *
 * <ul>
 *   <li>{@code frame}: the number of the frame.
 *   <li>{@code changes} and {@code late}: the changes before and after PHYSICS (the phase in which
 *       laws act).
 *   <li>{@code laws}: the changes of the laws.
 *   <li>{@code rules}: the changes of the rules.
 *   <li>{@code events}: the events, which a replay ignores.
 *   <li>{@code before}: the digest (checksum of the state) before PHYSICS, if there were changes.
 *   <li>{@code digest}: the digest at the end of the frame.
 * </ul>
 *
 * <p>Each digest contains only the parts that differ from the previous digest. One thread uses a
 * codec, and passes frames in order.
 */
public final class FrameCodec {
    private static final int PART_BYTES = Short.BYTES + 2 * Long.BYTES;

    private final ChangeCodec changes;
    private final long[] digest;
    private boolean whole;

    /**
     * @param digestSize number of parts of a digest
     */
    public FrameCodec(WorldHeader header, int digestSize) {
        changes = new ChangeCodec(header.prototype(), header.assets());
        digest = new long[digestSize];
    }

    /** Returns the codec of a frame's changes. */
    public ChangeCodec changes() {
        return changes;
    }

    /**
     * Makes the next written frame contain the complete digest. Called after an image was taken,
     * because a replay may start there.
     */
    void begin() {
        whole = true;
    }

    /**
     * Encodes a frame.
     *
     * @throws IllegalArgumentException if a change cannot be encoded
     */
    byte[] write(Entry entry) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("frame", entry.frame);
        if (!entry.early.isEmpty()) {
            tree.put("changes", entry.early.stream().map(this::tree).toList());
            tree.put("before", delta(entry.earlyDigest));
        }
        putIfAny(tree, "laws", entry.laws.stream().map(FrameCodec::tree).toList());
        putIfAny(tree, RuleCodec.KEY, RuleCodec.tree(entry.rules));
        putIfAny(tree, "late", entry.late.stream().map(this::tree).toList());
        putIfAny(tree, "events", entry.events.stream().map(FrameCodec::tree).toList());
        tree.put("digest", delta(entry.digest));
        return Trees.write(tree);
    }

    /**
     * Returns the complete digest of a frame; valid until the next call.
     *
     * @param name {@code before} or {@code digest}; if the frame has {@code before}, it must be
     *     read first
     * @throws CorruptException if it cannot be read
     */
    public long[] readDigest(JsonNode frame, String name) {
        ByteBuffer parts = ByteBuffer.wrap(decoded(name, Trees.text(frame, name)));
        while (parts.hasRemaining()) {
            int part = 2 * parts.getShort();
            if (part < 0 || part + 1 >= digest.length) {
                throw new CorruptException(
                        "the field " + name + ": found a digest of another prototype");
            }
            digest[part] = parts.getLong();
            digest[part + 1] = parts.getLong();
        }
        return digest;
    }

    private static byte[] decoded(String name, String text) {
        byte[] bytes;
        try {
            bytes = Base64.getDecoder().decode(text);
        } catch (IllegalArgumentException e) {
            throw new CorruptException(
                    "the field " + name + ": found no Base64, expected a digest", e);
        }
        if (bytes.length % PART_BYTES != 0) {
            throw new CorruptException(
                    "the field "
                            + name
                            + ": found "
                            + bytes.length
                            + " bytes, expected a digest in parts of "
                            + PART_BYTES
                            + " bytes");
        }
        return bytes;
    }

    /** Returns the changes of the rules in a frame. */
    public static List<RuleChanges.Change> rules(JsonNode frame) {
        return RuleCodec.read(frame);
    }

    /** Returns the changes of the laws in a frame. */
    public static List<LawChange> laws(
            JsonNode frame, Function<String, byte @Nullable []> libraries) {
        List<LawChange> laws = new ArrayList<>();
        List<JsonNode> changes = Trees.listIfAny(frame, "laws");
        changes.forEach(
                change ->
                        laws.add(
                                switch (Trees.text(change, "law")) {
                                    case "loaded" ->
                                            new LawChange.Loaded(
                                                    ImageCodec.library(change, libraries));
                                    case "replaced" ->
                                            new LawChange.Replaced(
                                                    (int) Trees.integer(change, "place"),
                                                    ImageCodec.library(change, libraries));
                                    case "rolled-back" ->
                                            new LawChange.RolledBack(
                                                    (int) Trees.integer(change, "place"),
                                                    ImageCodec.quarantined(
                                                            Trees.field(change, "failed")),
                                                    ImageCodec.library(change, libraries));
                                    case "unloaded" ->
                                            new LawChange.Unloaded(
                                                    (int) Trees.integer(change, "place"));
                                    case "arrested" ->
                                            new LawChange.Arrested(
                                                    new ItemId(Trees.integer(change, "item")));
                                    case "released" ->
                                            new LawChange.Released(Trees.text(change, "sha256"));
                                    case "unmoved" -> new LawChange.Unmoved();
                                    case "budget" ->
                                            new LawChange.BudgetSet(
                                                    (int) Trees.integer(change, "place"),
                                                    ImageCodec.budget(change));
                                    case "interval" ->
                                            new LawChange.IntervalSet(
                                                    (int) Trees.integer(change, "place"),
                                                    (int) Trees.integer(change, "interval"));
                                    case "parameters" ->
                                            new LawChange.ParametersSet(
                                                    (int) Trees.integer(change, "place"),
                                                    ImageCodec.parameters(change));
                                    default ->
                                            new LawChange.Failed(
                                                    (int) Trees.integer(change, "place"),
                                                    ImageCodec.quarantined(change));
                                }));
        return laws;
    }

    private Map<String, Object> tree(Entry.Noted noted) {
        return changes.write(noted.change(), noted.columnRows());
    }

    private static Map<String, Object> tree(LawChange change) {
        Map<String, Object> tree = new LinkedHashMap<>();
        switch (change) {
            case LawChange.Loaded added -> {
                tree.put("law", "loaded");
                tree.putAll(ImageCodec.tree(added.library()));
            }
            case LawChange.Replaced replaced -> {
                tree.put("law", "replaced");
                tree.put("place", replaced.place());
                tree.putAll(ImageCodec.tree(replaced.library()));
            }
            case LawChange.RolledBack back -> {
                tree.put("law", "rolled-back");
                tree.put("place", back.place());
                tree.put("failed", ImageCodec.tree(back.reason()));
                tree.putAll(ImageCodec.tree(back.library()));
            }
            case LawChange.Unloaded gone -> {
                tree.put("law", "unloaded");
                tree.put("place", gone.place());
            }
            case LawChange.ParametersSet set -> {
                tree.put("law", "parameters");
                tree.put("place", set.place());
                tree.put("parameters", set.changed());
            }
            case LawChange.BudgetSet set -> {
                tree.put("law", "budget");
                tree.put("place", set.place());
                set.budget().ifPresent(budget -> tree.put("budget", ImageCodec.tree(budget)));
            }
            case LawChange.IntervalSet set -> {
                tree.put("law", "interval");
                tree.put("place", set.place());
                tree.put("interval", set.interval());
            }
            case LawChange.Failed failed -> {
                tree.put("law", "failed");
                tree.put("place", failed.place());
                tree.putAll(ImageCodec.tree(failed.reason()));
            }
            case LawChange.Arrested arrested -> {
                tree.put("law", "arrested");
                tree.put("item", arrested.item().value());
            }
            case LawChange.Released released -> {
                tree.put("law", "released");
                tree.put("sha256", released.sha256());
            }
            case LawChange.Unmoved _ -> tree.put("law", "unmoved");
        }
        return tree;
    }

    private static Map<String, Object> tree(WorldEvent event) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("type", event.type());
        tree.put("fields", event.fields());
        return tree;
    }

    private static void putIfAny(Map<String, Object> tree, String key, List<?> list) {
        if (!list.isEmpty()) {
            tree.put(key, list);
        }
    }

    /**
     * Encodes the parts that changed since the last digest. Each part consists of its index (2
     * bytes) and its two numbers.
     */
    private String delta(long[] now) {
        ByteBuffer parts = ByteBuffer.allocate(PART_BYTES * now.length / 2);
        for (int i = 0; i < now.length; i += 2) {
            if (whole || now[i] != digest[i] || now[i + 1] != digest[i + 1]) {
                parts.putShort((short) (i / 2)).putLong(now[i]).putLong(now[i + 1]);
                digest[i] = now[i];
                digest[i + 1] = now[i + 1];
            }
        }
        whole = false;
        return Base64.getEncoder().encodeToString(Arrays.copyOf(parts.array(), parts.position()));
    }
}
