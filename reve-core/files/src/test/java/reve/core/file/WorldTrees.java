// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import org.snakeyaml.engine.v2.api.Load;
import org.snakeyaml.engine.v2.api.LoadSettings;
import org.snakeyaml.engine.v2.schema.CoreSchema;

import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.TreeMap;
import java.util.regex.Matcher;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/** The project's own world files as trees of maps, lists and values, and damage to them. */
final class WorldTrees {
    private static final Pattern YAML_BLOCK =
            Pattern.compile("^```yaml[^\n]*\n(.*?)^```", Pattern.MULTILINE | Pattern.DOTALL);

    /** Line by which experiments differ from world files. */
    private static final String EXPERIMENT = "experiment: 1";

    /** The values that damage puts in place of any value. */
    private static final List<Object> OTHERS =
            List.of(
                    0,
                    1,
                    -1,
                    3.0,
                    1.5,
                    1e300,
                    -1e-320,
                    99_999_999_999L,
                    true,
                    "",
                    " ",
                    "x",
                    "1 m",
                    "1 kg",
                    "-3 0 1e9 km/h",
                    "[1, 2] m",
                    "x".repeat(200),
                    "\t",
                    "\u202e",
                    "\ud83d\ude00",
                    "world",
                    "body",
                    "actor",
                    "{i}",
                    "{",
                    "{1/0}",
                    "{[1, 2]}",
                    "$p",
                    "$",
                    "$1 / 0",
                    "physics.mass > 1",
                    "semantic.x",
                    "item.name",
                    "../x",
                    "/dev/zero",
                    "x://y",
                    "#ff0000",
                    List.of(),
                    List.of(1),
                    List.of("x"),
                    List.of(1, 2, 3),
                    List.of(0, 0, 0, 0),
                    List.of(List.of(0, 0, 0), List.of(1, 0, 0), List.of(0, 1, 0)),
                    List.of(Map.of("raise", "x")),
                    Map.of(),
                    Map.of("x", 1),
                    Map.of("name", "x"),
                    Map.of("i", 3, "j", 2),
                    Map.of("mass", 1));

    private static final List<String> KEYS =
            List.of(
                    "x",
                    "Ä",
                    "a b",
                    "-",
                    "0",
                    "",
                    "name",
                    "like",
                    "kind",
                    "parent",
                    "repeat",
                    "parts",
                    "physical",
                    "semantic",
                    "access",
                    "physics",
                    "sensors",
                    "shape",
                    "location",
                    "density",
                    "mass",
                    "end1",
                    "when",
                    "needs",
                    "effects");

    private WorldTrees() {}

    /**
     * Changes a random place. The place then has another value or name, or one key more or less.
     */
    @SuppressWarnings("unchecked") // by construction
    static void mutate(Object world, Random random) {
        Object at = world;
        while (true) {
            List<Object> inner = new ArrayList<>();
            children(at)
                    .forEach(
                            child -> {
                                if (child instanceof Map<?, ?> || child instanceof List<?>) {
                                    inner.add(child);
                                }
                            });
            if (inner.isEmpty() || random.nextInt(4) == 0) {
                break;
            }
            at = inner.get(random.nextInt(inner.size()));
        }
        if (at instanceof List<?>) {
            mutateList((List<Object>) at, random);
        } else {
            mutateMapping((Map<String, Object>) at, random);
        }
    }

    private static void mutateList(List<Object> list, Random random) {
        if (list.isEmpty() || random.nextInt(4) == 0) {
            list.add(other(random));
        } else {
            list.set(random.nextInt(list.size()), other(random));
        }
    }

    private static void mutateMapping(Map<String, Object> map, Random random) {
        List<String> keys = List.copyOf(map.keySet());
        String key = keys.isEmpty() ? "x" : keys.get(random.nextInt(keys.size()));
        switch (random.nextInt(5)) {
            case 0 -> map.remove(key);
            case 1 -> map.put(key + "s", map.containsKey(key) ? map.remove(key) : 1);
            case 2 -> map.put(KEYS.get(random.nextInt(KEYS.size())), other(random));
            default -> map.put(key, other(random));
        }
    }

    private static Object other(Random random) {
        return copy(OTHERS.get(random.nextInt(OTHERS.size())));
    }

    private static Stream<?> children(Object value) {
        return value instanceof Map<?, ?> map
                ? map.values().stream()
                : value instanceof List<?> list ? list.stream() : Stream.of();
    }

    /** Returns a place that can be changed. */
    static Object copy(Object value) {
        if (value instanceof Map<?, ?> map) {
            var copy = new LinkedHashMap<Object, Object>();
            map.forEach((key, inner) -> copy.put(key, copy(inner)));
            return copy;
        }
        return value instanceof List<?> list
                ? new ArrayList<>(list.stream().map(WorldTrees::copy).toList())
                : value;
    }

    /** World files of the project, and the blocks of its documents that are whole worlds. */
    static Map<String, Object> worlds() throws IOException {
        Map<String, Object> worlds = new TreeMap<>();
        texts().forEach(
                        (file, text) -> {
                            if (text.contains("reve: 1")) {
                                worlds.put(file, loaded(text));
                            }
                        });
        blocks().forEach(
                        (place, text) -> {
                            if (text.contains("reve: 1") && !text.contains("name: mistakes")) {
                                worlds.put(place, loaded(text));
                            }
                        });
        return worlds;
    }

    /** Files of the project that worlds include. */
    static Map<String, Object> parts() throws IOException {
        Map<String, Object> parts = new TreeMap<>();
        texts().forEach(
                        (file, text) -> {
                            if (!text.contains("reve: 1")) {
                                parts.put(file, loaded(text));
                            }
                        });
        return parts;
    }

    /** Experiments of the project, and those in its documents. */
    static Map<String, Object> experiments() throws IOException {
        Map<String, Object> experiments = new TreeMap<>();
        Map<String, String> all = blocks();
        for (Path file : files("worlds", ".yaml")) {
            all.put(file.toString(), Files.readString(file));
        }
        all.forEach(
                (place, text) -> {
                    if (text.contains(EXPERIMENT)) {
                        experiments.put(place, loaded(text));
                    }
                });
        return experiments;
    }

    private static Map<String, String> texts() throws IOException {
        Map<String, String> texts = new TreeMap<>();
        for (String folder : List.of("worlds", "agents", "tests", "bench")) {
            for (Path file : files(folder, ".yaml")) {
                String text = Files.readString(file);
                if (!text.contains(EXPERIMENT)) {
                    texts.put(file.toString(), text);
                }
            }
        }
        return texts;
    }

    /**
     * World files of the project, and blocks of its documents that are whole worlds, as they are
     * written.
     */
    static List<String> sources() throws IOException {
        return Stream.concat(texts().values().stream(), blocks().values().stream())
                .filter(text -> text.contains("reve: 1"))
                .toList();
    }

    /** YAML in documents, by its place. */
    static Map<String, String> blocks() throws IOException {
        Map<String, String> blocks = new TreeMap<>();
        for (Path page : files("docs", ".md")) {
            Matcher block = YAML_BLOCK.matcher(Files.readString(page));
            while (block.find()) {
                blocks.put(page + " at " + block.start(), block.group(1));
            }
        }
        return blocks;
    }

    private static List<Path> files(String folder, String ending) throws IOException {
        try (Stream<Path> files = Files.walk(WorldFileTest.root().resolve(folder))) {
            return files.filter(file -> file.toString().endsWith(ending))
                    .filter(file -> !file.toString().contains("/build/"))
                    .sorted()
                    .toList();
        }
    }

    static Object loaded(String yaml) {
        return new Load(LoadSettings.builder().setSchema(new CoreSchema()).build())
                .loadFromString(yaml);
    }

    static String json(Object value) {
        return JsonMapper.shared().writeValueAsString(value);
    }
}
