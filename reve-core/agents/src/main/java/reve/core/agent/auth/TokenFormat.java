// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import reve.core.agent.protocol.Json;
import reve.core.agent.protocol.Role;
import reve.core.agent.protocol.Text;

import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.node.ArrayNode;
import tools.jackson.databind.node.ObjectNode;

import java.time.Instant;
import java.time.format.DateTimeParseException;
import java.util.ArrayList;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.TreeSet;

/**
 * The JSON format of token files. Unknown fields are refused, because ignoring a misspelt field
 * could grant more rights than intended.
 */
final class TokenFormat {

    private static final int VERSION = 1;
    private static final Set<String> FIELDS =
            Set.of(
                    "name",
                    "sha256",
                    "roles",
                    "worlds",
                    "bodies",
                    "capabilities",
                    "lockStep",
                    "laws",
                    "expires");

    private TokenFormat() {}

    static byte[] write(List<AgentToken> tokens) {
        ObjectNode file = Json.MAPPER.createObjectNode();
        file.put("reveTokens", VERSION);
        ArrayNode list = file.putArray("tokens");
        tokens.forEach(token -> write(token, list.addObject()));
        return Json.MAPPER.writerWithDefaultPrettyPrinter().writeValueAsBytes(file);
    }

    private static void write(AgentToken token, ObjectNode fields) {
        Rights rights = token.rights();
        fields.put("name", token.name());
        fields.put("sha256", token.sha256());
        put(
                fields,
                "roles",
                Optional.of(new TreeSet<>(rights.roles().stream().map(Role::wireName).toList())));
        put(fields, "worlds", rights.worlds());
        put(fields, "bodies", rights.bodies());
        put(fields, "capabilities", rights.capabilities());
        if (rights.lockStep()) {
            fields.put("lockStep", true);
        }
        put(fields, "laws", rights.laws());
        token.expires().ifPresent(instant -> fields.put("expires", instant.toString()));
    }

    private static void put(ObjectNode fields, String name, Optional<? extends Set<String>> names) {
        names.ifPresent(
                set -> {
                    ArrayNode list = fields.putArray(name);
                    new TreeSet<>(set).forEach(list::add);
                });
    }

    /**
     * Reads the tokens of a file.
     *
     * @throws IllegalArgumentException naming the invalid token and the error
     */
    static List<AgentToken> read(byte[] bytes) {
        JsonNode file;
        try {
            file = Json.MAPPER.readTree(bytes);
        } catch (JacksonException e) {
            throw new IllegalArgumentException(
                    "it is not JSON"
                            + (e.getLocation() == null
                                    ? ""
                                    : ": line "
                                            + e.getLocation().getLineNr()
                                            + ", column "
                                            + e.getLocation().getColumnNr()
                                            + " cannot be read"),
                    e);
        }
        if (file.path("reveTokens").asInt(0) != VERSION || !file.path("tokens").isArray()) {
            throw new IllegalArgumentException(
                    "expected {\"reveTokens\": " + VERSION + ", \"tokens\": [...]}");
        }
        var tokens = new ArrayList<AgentToken>();
        for (JsonNode fields : file.get("tokens").values()) {
            tokens.add(read("token " + (tokens.size() + 1), fields));
        }
        return tokens;
    }

    private static AgentToken read(String which, JsonNode fields) {
        for (Map.Entry<String, JsonNode> field : fields.properties()) {
            if (!FIELDS.contains(field.getKey())) {
                throw new IllegalArgumentException(
                        which
                                + " has the field "
                                + Text.quote(field.getKey())
                                + ", expected some of "
                                + String.join(", ", new TreeSet<>(FIELDS)));
            }
        }
        var roles = new LinkedHashSet<Role>();
        for (String role : names(which, fields, "roles").orElse(Set.of())) {
            roles.add(
                    Role.of(role)
                            .orElseThrow(
                                    () ->
                                            new IllegalArgumentException(
                                                    which
                                                            + " has the role "
                                                            + Text.quote(role)
                                                            + ", expected some of "
                                                            + Role.names())));
        }
        try {
            return new AgentToken(
                    text(fields, "name"),
                    text(fields, "sha256"),
                    new Rights(
                            roles,
                            names(which, fields, "worlds"),
                            names(which, fields, "bodies"),
                            names(which, fields, "capabilities"),
                            truth(fields, "lockStep"),
                            names(which, fields, "laws")),
                    fields.has("expires")
                            ? Optional.of(Instant.parse(text(fields, "expires")))
                            : Optional.empty());
        } catch (DateTimeParseException e) {
            throw new IllegalArgumentException(
                    which
                            + " expires "
                            + Text.quote(text(fields, "expires"))
                            + ", expected a time such as 2030-01-31T12:00:00Z",
                    e);
        } catch (IllegalArgumentException e) {
            throw new IllegalArgumentException(which + ": " + e.getMessage(), e);
        }
    }

    private static String text(JsonNode fields, String name) {
        JsonNode field = fields.path(name);
        if (!field.isString()) {
            throw new IllegalArgumentException(name + " is not a text");
        }
        return field.stringValue();
    }

    private static boolean truth(JsonNode fields, String name) {
        JsonNode field = fields.path(name);
        if (!field.isMissingNode() && !field.isBoolean()) {
            throw new IllegalArgumentException(name + " is neither true nor false");
        }
        return field.asBoolean(false);
    }

    private static Optional<Set<String>> names(String which, JsonNode fields, String name) {
        JsonNode field = fields.path(name);
        if (field.isMissingNode()) {
            return Optional.empty();
        }
        var names = new LinkedHashSet<String>();
        for (JsonNode element : field.values()) {
            if (!element.isString()) {
                throw new IllegalArgumentException(which + ": " + name + " is not a list of texts");
            }
            names.add(element.stringValue());
        }
        if (!field.isArray()) {
            throw new IllegalArgumentException(which + ": " + name + " is not a list of texts");
        }
        return Optional.of(names);
    }
}
