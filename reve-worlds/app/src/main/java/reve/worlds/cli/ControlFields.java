// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.jspecify.annotations.Nullable;
import org.snakeyaml.engine.v2.api.Load;
import org.snakeyaml.engine.v2.api.LoadSettings;
import org.snakeyaml.engine.v2.exceptions.YamlEngineException;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.stream.Collectors;

/** The fields of a command of the role control, read from arguments and files. */
final class ControlFields {
    private static final int MAX_BYTES = 1 << 20;

    private ControlFields() {}

    /** Returns whether an argument names a file of YAML or JSON. */
    static boolean isFile(String argument) {
        return argument.matches("[^=]*\\.(yaml|yml|json)");
    }

    /**
     * Reads the fields of a command from a file.
     *
     * @param command add, change, batch or fork
     * @throws IOException if the file cannot be read, is not YAML, or does not fit the command
     */
    static Map<String, Object> read(String command, Path file) throws IOException {
        Object content = load(file);
        Map<String, Object> fields = new LinkedHashMap<>();
        switch (command) {
            case "add" -> {
                if (content instanceof Map<?, ?> map && map.containsKey("items")) {
                    map.forEach((key, value) -> fields.put(String.valueOf(key), value));
                } else {
                    fields.put("items", content instanceof List<?> ? content : List.of(content));
                }
            }
            case "change" -> {
                Map<String, Object> to = new LinkedHashMap<>();
                mapping(file, content).forEach((key, value) -> to.put(String.valueOf(key), value));
                if (to.remove("name") instanceof String item) {
                    fields.put("item", item);
                }
                fields.put("to", to);
            }
            default ->
                    fields.put(
                            "changes",
                            content instanceof List<?>
                                    ? content
                                    : mapping(file, content).get("changes"));
        }
        return fields;
    }

    private static Map<?, ?> mapping(Path file, @Nullable Object content) throws IOException {
        if (content instanceof Map<?, ?> map) {
            return map;
        }
        throw new IOException(file + ": expected a mapping, such as the item of a world file");
    }

    private static Object load(Path file) throws IOException {
        if (!Files.exists(file)) {
            throw new NoSuchFileException("there is no file " + file);
        }
        if (!Files.isRegularFile(file)) {
            throw new IOException(file + " is a folder, a device or a pipe, expected a file");
        }
        if (Files.size(file) > MAX_BYTES) {
            throw new IOException(file + " has more than " + MAX_BYTES + " bytes");
        }
        try {
            Object content =
                    new Load(LoadSettings.builder().build()).loadFromString(Files.readString(file));
            if (content == null) {
                throw new IOException(file + " is empty");
            }
            return content;
        } catch (YamlEngineException wrong) {
            String message =
                    String.valueOf(wrong.getMessage())
                            .lines()
                            .map(String::strip)
                            .collect(Collectors.joining(" "));
            throw new IOException(file + " is not YAML: " + message, wrong);
        } catch (StackOverflowError deep) {
            // The parser calls itself for each bracket, so deep nesting exhausts the stack.
            throw new IOException(
                    file + " is nested too deeply; expected an item, a rule or a list of edits",
                    deep);
        }
    }

    /**
     * Adds a value to nested mappings. A path such as {@code physics.mass} names the place of the
     * value.
     */
    static void put(Map<String, Object> fields, String path, @Nullable Object value) {
        Map<String, Object> inner = fields;
        String[] keys = path.split("\\.");
        for (int i = 0; i < keys.length - 1; i++) {
            inner = nested(inner.computeIfAbsent(keys[i], _ -> new LinkedHashMap<>()));
        }
        inner.put(keys[keys.length - 1], value);
    }

    @SuppressWarnings("unchecked") // safe: only this class puts maps into the fields
    private static Map<String, Object> nested(Object map) {
        return (Map<String, Object>) map;
    }
}
