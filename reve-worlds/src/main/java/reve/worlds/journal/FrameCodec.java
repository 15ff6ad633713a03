// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.store.ChangeCodec;
import reve.core.store.CorruptException;
import reve.core.store.Trees;
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
 * Frames of a journal as JSON: {@code frame}, {@code changes} before PHYSICS and {@code late} ones
 * after it, changes of the {@code laws}, the {@code events} for whoever reads it, and digests:
 * {@code before} PHYSICS where there were changes, and the {@code digest} of the frame's end, each
 * the part that is not as in the one before it. One thread; frames in their order.
 */
public final class FrameCodec {
    private static final int PART_BYTES = Short.BYTES + 2 * Long.BYTES;

    private final ChangeCodec changes;
    private final long[] digest;
    private boolean whole;

    /**
     * @param digestSize how many numbers a digest has
     */
    public FrameCodec(WorldHeader header, int digestSize) {
        changes = new ChangeCodec(header.prototype(), header.assets());
        digest = new long[digestSize];
    }

    /** Reads the changes of a frame. */
    public ChangeCodec changes() {
        return changes;
    }

    /** An image was taken: the next frame that is written has the whole digest. */
    void begin() {
        whole = true;
    }

    /**
     * @throws IllegalArgumentException if a change of it has no form
     */
    byte[] write(Entry entry) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("frame", entry.frame);
        if (!entry.early.isEmpty()) {
            tree.put("changes", entry.early.stream().map(this::tree).toList());
            tree.put("before", delta(entry.earlyDigest));
        }
        putIfAny(tree, "laws", entry.laws.stream().map(FrameCodec::tree).toList());
        putIfAny(tree, "late", entry.late.stream().map(this::tree).toList());
        putIfAny(tree, "events", entry.events.stream().map(FrameCodec::tree).toList());
        tree.put("digest", delta(entry.digest));
        return Trees.write(tree);
    }

    /**
     * A whole digest of a frame that was read; valid until the next one.
     *
     * @param name {@code before}, which some frames have, then {@code digest}
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

    /** Changes of the laws of a frame. */
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
                                    case "unloaded" ->
                                            new LawChange.Unloaded(
                                                    (int) Trees.integer(change, "place"));
                                    case "arrested" ->
                                            new LawChange.Arrested(
                                                    new ItemId(Trees.integer(change, "item")));
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
            case LawChange.Unloaded gone -> {
                tree.put("law", "unloaded");
                tree.put("place", gone.place());
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

    /** Parts that changed since the last frame: their place (2 bytes) and both numbers. */
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
