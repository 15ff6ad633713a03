// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.eclipse.jetty.http.HttpHeader;
import org.eclipse.jetty.http.HttpStatus;
import org.eclipse.jetty.server.Handler;
import org.eclipse.jetty.server.Request;
import org.eclipse.jetty.server.Response;
import org.eclipse.jetty.util.Callback;
import org.jspecify.annotations.Nullable;

import reve.core.agent.AgentServer;
import reve.core.agent.auth.AgentToken;
import reve.core.agent.auth.Rights;
import reve.core.agent.auth.TokenFile;
import reve.core.agent.port.WorldPort;
import reve.core.agent.protocol.Role;

import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.util.List;
import java.util.Optional;
import java.util.Set;

/**
 * The HTTP paths for monitoring. The path {@code /health} answers 200 if all worlds make frames or
 * wait, and 503 otherwise; it names no world. The path {@code /metrics} returns the counters. The
 * counters require a bearer token with the role observer or control if the server requires tokens.
 * A token for some worlds reads the counters of these worlds only.
 */
final class Operations extends Handler.Wrapper {

    private static final String BEARER = "Bearer ";
    private static final Set<Role> READERS = Set.of(Role.OBSERVER, Role.CONTROL);

    /** The present worlds; the list may change at any time. */
    private final List<WorldPort> worlds;

    private final AgentServer agents;
    private final Optional<TokenFile> tokens;

    Operations(List<WorldPort> worlds, AgentServer agents, Optional<TokenFile> tokens) {
        this.worlds = worlds;
        this.agents = agents;
        this.tokens = tokens;
    }

    @Override
    public boolean handle(Request request, Response response, Callback callback) throws Exception {
        return switch (Request.getPathInContext(request)) {
            case "/health" -> health(response, callback);
            case "/metrics" -> metrics(request, response, callback);
            default -> super.handle(request, response, callback);
        };
    }

    private boolean health(Response response, Callback callback) {
        long ended = worlds.stream().filter(world -> !Metrics.isRunning(world.loop())).count();
        response.setStatus(ended == 0 ? HttpStatus.OK_200 : HttpStatus.SERVICE_UNAVAILABLE_503);
        write(
                response,
                "text/plain; charset=utf-8",
                (ended == 0 ? "ok\n" : ended + " worlds make no frames\n")
                        .getBytes(StandardCharsets.UTF_8),
                callback);
        return true;
    }

    private boolean metrics(Request request, Response response, Callback callback) {
        Optional<Rights> reader = reader(request.getHeaders().get(HttpHeader.AUTHORIZATION));
        if (reader.isPresent()) {
            write(response, Metrics.TYPE, counters(reader.get()).text(), callback);
        } else {
            response.getHeaders().put(HttpHeader.WWW_AUTHENTICATE, "Bearer");
            Response.writeError(
                    request,
                    response,
                    callback,
                    HttpStatus.UNAUTHORIZED_401,
                    "a bearer token with the role observer or control is needed");
        }
        return true;
    }

    /** Returns the counters of the worlds that a client may read. */
    private Metrics counters(Rights rights) {
        return new Metrics(
                worlds.stream().filter(world -> rights.opensWorld(world.world())).toList(),
                rights.worlds().isEmpty() ? Optional.of(agents) : Optional.empty());
    }

    /**
     * Returns the rights of the request's token; empty if the token does not permit reading the
     * counters.
     */
    private Optional<Rights> reader(@Nullable String authorization) {
        return rights(tokens, authorization)
                .filter(rights -> rights.roles().stream().anyMatch(READERS::contains));
    }

    /**
     * Returns the rights of a bearer token; all rights if the server uses no tokens, and empty if
     * there is no valid token.
     *
     * @param authorization the header {@code Authorization} of a request
     */
    static Optional<Rights> rights(Optional<TokenFile> tokens, @Nullable String authorization) {
        if (tokens.isEmpty()) {
            return Optional.of(Rights.ALL);
        }
        if (authorization == null || !authorization.startsWith(BEARER)) {
            return Optional.empty();
        }
        return tokens.get().find(authorization.substring(BEARER.length())).map(AgentToken::rights);
    }

    static void write(Response response, String type, byte[] bytes, Callback callback) {
        response.getHeaders().put(HttpHeader.CONTENT_TYPE, type);
        response.getHeaders().put(HttpHeader.CACHE_CONTROL, "no-store");
        response.write(true, ByteBuffer.wrap(bytes), callback);
    }
}
