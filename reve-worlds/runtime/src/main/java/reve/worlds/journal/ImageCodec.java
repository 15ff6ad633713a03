// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.file.RuleChanges;
import reve.core.frame.TimeBudget;
import reve.core.image.CorruptException;
import reve.core.image.Sections;
import reve.core.image.Trees;
import reve.core.image.WorldImageCodec;
import reve.core.world.OffHeapArena;
import reve.core.world.World;
import reve.pe.Status;
import reve.pe.adapter.LawLibrary;
import reve.pe.adapter.PhysicsImage;
import reve.pe.adapter.Quarantined;
import reve.worlds.Product;

import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.function.Function;

/**
 * The codec of simulation images as bytes. An image is the complete state of a simulation. It names
 * law libraries by their SHA-256; the libraries' bytes are stored separately. For one thread.
 */
public final class ImageCodec {
    private static final String HEADER = "header";
    private static final String ENGINE = "engine";

    private final WorldHeader header;
    private final WorldImageCodec worlds;

    /** Creates a codec for images of worlds that match this header. */
    public ImageCodec(WorldHeader header) {
        this.header = header;
        this.worlds = new WorldImageCodec(header.prototype(), header.assets());
    }

    /**
     * An image of which only the outer structure was read. Its content is not decoded yet.
     *
     * @param members ids of the agents' bodies by agent
     * @param rules the changes of the rules since the world file
     */
    public record Stored(
            WorldHeader header,
            Map<String, Long> members,
            RuleChanges rules,
            JsonNode tree,
            Map<String, byte[]> sections) {}

    /**
     * Encodes an image.
     *
     * @param members ids of the agents' bodies by agent
     * @param rules the changes of the rules since the world file
     * @throws IllegalArgumentException if an item of the world has no form in a world file
     */
    public byte[] write(SimulationImage image, Map<String, Long> members, RuleChanges rules) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("product", Product.version());
        tree.putAll(header.tree());
        tree.put("members", members);
        if (!rules.isEmpty()) {
            tree.put(RuleCodec.KEY, RuleCodec.tree(rules.changes()));
        }
        tree.put("libraries", image.physics().libraries().stream().map(ImageCodec::tree).toList());
        tree.put(
                "quarantined",
                image.physics().quarantined().stream().map(ImageCodec::tree).toList());
        Map<String, byte[]> sections = new LinkedHashMap<>();
        sections.put(HEADER, Trees.write(tree));
        sections.put(ENGINE, image.physics().engineState());
        sections.putAll(worlds.write(image.world()));
        return Sections.write(sections);
    }

    /**
     * Reads the outer structure of an image.
     *
     * @throws CorruptException with the reason, if the bytes are damaged
     */
    public static Stored open(byte[] bytes) {
        Map<String, byte[]> sections = Sections.read(bytes);
        byte[] head = sections.get(HEADER);
        if (head == null) {
            throw new CorruptException("it has no header");
        }
        try {
            JsonNode tree = Trees.read(head);
            Map<String, Long> members = new LinkedHashMap<>();
            JsonNode listed = Trees.field(tree, "members");
            for (String agent : listed.propertyNames()) {
                members.put(agent, Trees.integer(listed, agent));
            }
            RuleChanges rules = new RuleChanges(RuleCodec.read(tree));
            return new Stored(WorldHeader.read(tree), members, rules, tree, sections);
        } catch (IllegalArgumentException | JacksonException e) {
            throw new CorruptException("its header makes no sense: " + e.getMessage(), e);
        }
    }

    /**
     * Decodes an image; the caller closes it.
     *
     * @param libraries returns the bytes of a law library by SHA-256, or null if there is none
     * @throws CorruptException if the image is inconsistent, or a library is missing
     */
    public SimulationImage read(Stored stored, Function<String, byte @Nullable []> libraries) {
        SimulationImage image;
        try (OffHeapArena arena = new OffHeapArena()) {
            image = new SimulationImage(new World(header.name(), header.prototype(), arena));
        }
        try {
            worlds.read(stored.sections(), image.world());
            image.setPhysics(physics(stored, libraries));
            return image;
        } catch (RuntimeException e) {
            image.close();
            throw e;
        }
    }

    private static PhysicsImage physics(
            Stored stored, Function<String, byte @Nullable []> libraries) {
        byte[] engine = stored.sections().get(ENGINE);
        if (engine == null) {
            throw new CorruptException("the section engine is missing");
        }
        return new PhysicsImage(libraries(stored, libraries), quarantined(stored), engine);
    }

    /**
     * Returns the law libraries of an image, in the order of loading.
     *
     * @param libraries returns the bytes of a law library by SHA-256, or null if there is none
     * @throws CorruptException if a library is missing
     */
    public static List<LawLibrary> libraries(
            Stored stored, Function<String, byte @Nullable []> libraries) {
        List<LawLibrary> loaded = new ArrayList<>();
        Trees.field(stored.tree(), "libraries")
                .forEach(library -> loaded.add(library(library, libraries)));
        return loaded;
    }

    /** Returns the quarantined libraries of an image. */
    public static List<Quarantined> quarantined(Stored stored) {
        List<Quarantined> out = new ArrayList<>();
        Trees.field(stored.tree(), "quarantined").forEach(tree -> out.add(quarantined(tree)));
        return out;
    }

    static Map<String, Object> tree(LawLibrary library) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("library", library.name());
        tree.put("sha256", library.sha256());
        tree.put("parameters", library.parameters());
        library.budget().ifPresent(budget -> tree.put("budget", tree(budget)));
        if (library.interval() != 1) {
            tree.put("interval", library.interval());
        }
        if (!library.versions().isEmpty()) {
            tree.put("versions", library.versions());
        }
        return tree;
    }

    static LawLibrary library(JsonNode tree, Function<String, byte @Nullable []> libraries) {
        String name = Trees.text(tree, "library");
        String sha256 = Trees.text(tree, "sha256");
        byte[] bytes = libraries.apply(sha256);
        if (bytes == null) {
            throw new CorruptException(
                    "the law library " + name + " (SHA-256 " + sha256 + ") is missing or damaged");
        }
        return new LawLibrary(
                name,
                sha256,
                parameters(tree),
                bytes,
                budget(tree),
                tree.has("interval") ? (int) Trees.integer(tree, "interval") : 1,
                tree.has("versions") ? Trees.text(tree, "versions") : "");
    }

    static Map<String, Object> tree(TimeBudget budget) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("nanoseconds", budget.nanoseconds());
        tree.put("frames", budget.frames());
        tree.put("then", budget.response().text());
        tree.put("every", budget.every());
        return tree;
    }

    /**
     * Returns the budget of a library, or the budget in a change of its budget; empty if there is
     * none.
     */
    static Optional<TimeBudget> budget(JsonNode tree) {
        if (!tree.has("budget")) {
            return Optional.empty();
        }
        JsonNode budget = Trees.field(tree, "budget");
        String then = Trees.text(budget, "then");
        try {
            return Optional.of(
                    new TimeBudget(
                            Trees.integer(budget, "nanoseconds"),
                            (int) Trees.integer(budget, "frames"),
                            TimeBudget.Response.find(then)
                                    .orElseThrow(
                                            () ->
                                                    new IllegalArgumentException(
                                                            "no response " + then)),
                            (int) Trees.integer(budget, "every")));
        } catch (IllegalArgumentException invalid) {
            throw new CorruptException("the budget of a law: " + invalid.getMessage(), invalid);
        }
    }

    static Map<String, Double> parameters(JsonNode tree) {
        Map<String, Double> parameters = new LinkedHashMap<>();
        Trees.field(tree, "parameters")
                .properties()
                .forEach(
                        parameter ->
                                parameters.put(
                                        parameter.getKey(),
                                        Trees.number("a parameter", parameter.getValue())));
        return parameters;
    }

    static Map<String, Object> tree(Quarantined reason) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("sha256", reason.sha256());
        tree.put("library", reason.library());
        tree.put("frame", reason.frame());
        tree.put("status", reason.status().name());
        tree.put("message", reason.message());
        return tree;
    }

    static Quarantined quarantined(JsonNode tree) {
        return new Quarantined(
                Trees.text(tree, "sha256"),
                Trees.text(tree, "library"),
                Trees.integer(tree, "frame"),
                Status.valueOf(Trees.text(tree, "status")),
                Trees.text(tree, "message"));
    }
}
