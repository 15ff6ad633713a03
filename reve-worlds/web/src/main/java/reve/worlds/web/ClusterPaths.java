// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.eclipse.jetty.http.HttpHeader;
import org.eclipse.jetty.http.HttpMethod;
import org.eclipse.jetty.http.HttpStatus;
import org.eclipse.jetty.server.Handler;
import org.eclipse.jetty.server.Request;
import org.eclipse.jetty.server.Response;
import org.eclipse.jetty.util.Callback;
import org.eclipse.jetty.util.Fields;

import reve.core.agent.auth.Rights;
import reve.core.agent.auth.TokenFile;
import reve.core.agent.port.ClusterPort;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Role;
import reve.core.world.ActionRefused;

import tools.jackson.databind.json.JsonMapper;

import java.nio.charset.StandardCharsets;
import java.util.Map;
import java.util.Optional;
import java.util.function.Supplier;

/**
 * The HTTP paths of the page of the nodes. {@code GET /cluster} returns the nodes and worlds of the
 * cluster. {@code POST /cluster/move} and {@code POST /cluster/drain} give orders. They need no
 * world, because all worlds of a cluster may sleep. If the server uses tokens, a request needs a
 * bearer token that permits the same message of the protocol in the role control.
 */
final class ClusterPaths extends Handler.Wrapper {
    private static final String STATE = "/cluster";
    private static final String MOVE = "/cluster/move";
    private static final String DRAIN = "/cluster/drain";
    private static final String JSON_TYPE = "application/json";
    private static final JsonMapper JSON = new JsonMapper();

    private final Supplier<Optional<ClusterPort>> cluster;
    private final Optional<TokenFile> tokens;

    /**
     * @param cluster returns the cluster; empty if the server belongs to none
     */
    ClusterPaths(Supplier<Optional<ClusterPort>> cluster, Optional<TokenFile> tokens) {
        this.cluster = cluster;
        this.tokens = tokens;
    }

    @Override
    public boolean handle(Request request, Response response, Callback callback) throws Exception {
        String path = Request.getPathInContext(request);
        if (!path.equals(STATE) && !path.equals(MOVE) && !path.equals(DRAIN)) {
            return super.handle(request, response, callback);
        }
        HttpMethod method = path.equals(STATE) ? HttpMethod.GET : HttpMethod.POST;
        if (!method.is(request.getMethod())) {
            refuse(
                    response,
                    callback,
                    HttpStatus.METHOD_NOT_ALLOWED_405,
                    "wrong-method",
                    path + " takes " + method);
            return true;
        }
        Optional<Rights> rights =
                Operations.rights(tokens, request.getHeaders().get(HttpHeader.AUTHORIZATION));
        if (rights.isEmpty()) {
            response.getHeaders().put(HttpHeader.WWW_AUTHENTICATE, "Bearer");
            refuse(
                    response,
                    callback,
                    HttpStatus.UNAUTHORIZED_401,
                    "bad-token",
                    "this server takes a token, and there was none or a wrong one");
            return true;
        }
        try {
            ClientMessage.Request asked = asked(path, Request.extractQueryParameters(request));
            Optional<String> refusal =
                    rights.get().roles().contains(Role.CONTROL)
                            ? rights.get().refusal(asked)
                            : Optional.of("it does not open the role control");
            if (refusal.isPresent()) {
                refuse(
                        response,
                        callback,
                        HttpStatus.FORBIDDEN_403,
                        "not-permitted",
                        "your token does not permit this: " + refusal.get());
            } else {
                answer(asked, response, callback);
            }
        } catch (ActionRefused refused) {
            refuse(
                    response,
                    callback,
                    HttpStatus.CONFLICT_409,
                    refused.code(),
                    String.valueOf(refused.getMessage()));
        }
        return true;
    }

    /** Returns the message of the protocol that stands for a request. */
    private static ClientMessage.Request asked(String path, Fields query) throws ActionRefused {
        return switch (path) {
            case MOVE -> new ClientMessage.MoveWorld(0, text(query, "world"), text(query, "node"));
            case DRAIN ->
                    new ClientMessage.DrainNode(0, text(query, "node"), isTrue(query, "drained"));
            default -> new ClientMessage.Ask(0, "cluster", Map.of());
        };
    }

    private void answer(ClientMessage.Request asked, Response response, Callback callback)
            throws ActionRefused {
        Optional<ClusterPort> known = cluster.get();
        if (known.isEmpty()) {
            refuse(
                    response,
                    callback,
                    HttpStatus.SERVICE_UNAVAILABLE_503,
                    "unsupported",
                    "this server belongs to no cluster");
            return;
        }
        Map<String, Object> value =
                switch (asked) {
                    case ClientMessage.MoveWorld move ->
                            known.get().move(move.world(), move.node());
                    case ClientMessage.DrainNode drain ->
                            known.get().drain(drain.node(), drain.drained());
                    default -> known.get().state();
                };
        Operations.write(response, JSON_TYPE, bytes(value), callback);
    }

    private static String text(Fields query, String name) throws ActionRefused {
        String value = query.getValue(name);
        if (value == null || value.isEmpty()) {
            throw new ActionRefused("bad-message", "the field '" + name + "' is missing");
        }
        return value;
    }

    private static boolean isTrue(Fields query, String name) throws ActionRefused {
        return switch (text(query, name)) {
            case "true" -> true;
            case "false" -> false;
            default ->
                    throw new ActionRefused(
                            "bad-message", "the field '" + name + "' is neither true nor false");
        };
    }

    private static void refuse(
            Response response, Callback callback, int status, String code, String reason) {
        response.setStatus(status);
        Operations.write(
                response, JSON_TYPE, bytes(Map.of("code", code, "reason", reason)), callback);
    }

    private static byte[] bytes(Map<String, Object> value) {
        return JSON.writeValueAsString(value).getBytes(StandardCharsets.UTF_8);
    }
}
