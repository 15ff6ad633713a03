// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.eclipse.jetty.http.HttpHeader;
import org.eclipse.jetty.http.HttpStatus;
import org.eclipse.jetty.server.Handler;
import org.eclipse.jetty.server.Request;
import org.eclipse.jetty.server.Response;
import org.eclipse.jetty.util.Callback;
import org.jspecify.annotations.Nullable;

import reve.core.agent.auth.TokenFile;
import reve.core.agent.protocol.Role;

import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.util.List;
import java.util.Optional;
import java.util.Set;

/**
 * The paths for supervisors: {@code /health} answers 200 if all worlds make frames or wait, else
 * 503, and names no world; {@code /metrics} has the counters. On a server with tokens, the counters
 * need one with the role observer or control, as a bearer token.
 */
final class Operations extends Handler.Wrapper {

    private static final String BEARER = "Bearer ";
    private static final Set<Role> READERS = Set.of(Role.OBSERVER, Role.CONTROL);

    private final Metrics metrics;
    private final Optional<TokenFile> tokens;

    Operations(Metrics metrics, Optional<TokenFile> tokens) {
        this.metrics = metrics;
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
        List<String> ended = metrics.ended();
        response.setStatus(
                ended.isEmpty() ? HttpStatus.OK_200 : HttpStatus.SERVICE_UNAVAILABLE_503);
        write(
                response,
                "text/plain; charset=utf-8",
                (ended.isEmpty() ? "ok\n" : ended.size() + " worlds make no frames\n")
                        .getBytes(StandardCharsets.UTF_8),
                callback);
        return true;
    }

    private boolean metrics(Request request, Response response, Callback callback) {
        if (mayRead(request.getHeaders().get(HttpHeader.AUTHORIZATION))) {
            write(response, Metrics.TYPE, metrics.text(), callback);
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

    private boolean mayRead(@Nullable String authorization) {
        return tokens.isEmpty()
                || authorization != null
                        && authorization.startsWith(BEARER)
                        && tokens.get()
                                .find(authorization.substring(BEARER.length()))
                                .filter(
                                        token ->
                                                token.rights().roles().stream()
                                                        .anyMatch(READERS::contains))
                                .isPresent();
    }

    private static void write(Response response, String type, byte[] bytes, Callback callback) {
        response.getHeaders().put(HttpHeader.CONTENT_TYPE, type);
        response.getHeaders().put(HttpHeader.CACHE_CONTROL, "no-store");
        response.write(true, ByteBuffer.wrap(bytes), callback);
    }
}
