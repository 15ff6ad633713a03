// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.eclipse.jetty.http.HttpHeader;
import org.eclipse.jetty.http.HttpMethod;
import org.eclipse.jetty.http.HttpStatus;
import org.eclipse.jetty.server.Handler;
import org.eclipse.jetty.server.Request;
import org.eclipse.jetty.server.Response;
import org.eclipse.jetty.util.Callback;

import java.net.URI;
import java.util.List;
import java.util.Set;

/**
 * Refuses requests that a page of another origin may have caused. The Host header of a request must
 * name this server. This prevents DNS rebinding, an attack in which the name of another site
 * resolves to this server. A WebSocket, and a request that gives an order (POST), must come from a
 * page of this origin.
 */
final class HostGuard extends Handler.Wrapper {

    private static final Set<String> LOOPBACK = Set.of("127.0.0.1", "localhost", "[::1]");

    private final boolean loopback;

    /**
     * @param loopback true if the server listens on a loopback address only
     */
    HostGuard(boolean loopback) {
        this.loopback = loopback;
    }

    @Override
    public boolean handle(Request request, Response response, Callback callback) throws Exception {
        String host = request.getHeaders().get(HttpHeader.HOST);
        if (host == null || loopback && !LOOPBACK.contains(withoutPort(host))) {
            Response.writeError(
                    request,
                    response,
                    callback,
                    HttpStatus.MISDIRECTED_REQUEST_421,
                    "this server is reached as 127.0.0.1 or localhost");
            return true;
        }
        boolean upgrades =
                "websocket".equalsIgnoreCase(request.getHeaders().get(HttpHeader.UPGRADE));
        List<String> origins = request.getHeaders().getValuesList(HttpHeader.ORIGIN);
        boolean orders = HttpMethod.POST.is(request.getMethod());
        if ((upgrades || orders)
                && (origins.size() != 1 || !isOwn(origins.getFirst(), request, host))) {
            Response.writeError(
                    request,
                    response,
                    callback,
                    HttpStatus.FORBIDDEN_403,
                    upgrades
                            ? "a WebSocket is opened by the page of this server only"
                            : "orders are given by the page of this server only");
            return true;
        }
        return super.handle(request, response, callback);
    }

    private static boolean isOwn(String origin, Request request, String host) {
        try {
            URI uri = URI.create(origin);
            return (request.isSecure() ? "https" : "http").equals(uri.getScheme())
                    && host.equalsIgnoreCase(uri.getAuthority());
        } catch (IllegalArgumentException malformed) {
            return false;
        }
    }

    private static String withoutPort(String host) {
        int colon = host.lastIndexOf(':');
        return colon > host.lastIndexOf(']') ? host.substring(0, colon) : host;
    }
}
