// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.eclipse.jetty.http.HttpHeader;
import org.eclipse.jetty.http.HttpMethod;
import org.eclipse.jetty.http.HttpStatus;
import org.eclipse.jetty.server.Handler;
import org.eclipse.jetty.server.Request;
import org.eclipse.jetty.server.Response;
import org.eclipse.jetty.util.Callback;

import java.io.IOException;
import java.io.InputStream;
import java.io.UncheckedIOException;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.security.MessageDigest;
import java.security.NoSuchAlgorithmException;
import java.util.Base64;
import java.util.HexFormat;
import java.util.Map;
import java.util.TreeMap;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/**
 * Serves the files of the web page from jars on the class path, and no other files. The content
 * security policy allows the page to send requests to this server only.
 */
final class PageFiles extends Handler.Abstract.NonBlocking {

    private static final String OWN = "reve/worlds/web/page/";
    private static final String THREE = "META-INF/resources/webjars/three/0.181.1/";
    private static final String UPLOT = "META-INF/resources/webjars/uplot/1.6.30/";

    private static final String HTML = "text/html; charset=utf-8";
    private static final String SCRIPT = "text/javascript; charset=utf-8";
    private static final String STYLE = "text/css; charset=utf-8";
    private static final String ICON = "image/svg+xml";

    private static final Pattern INLINE =
            Pattern.compile("<script type=\"importmap\">(.*?)</script>", Pattern.DOTALL);

    private final Map<String, Page> files = new TreeMap<>();
    private final String policy;

    private record Page(byte[] bytes, String type, String tag) {}

    PageFiles() {
        add("/", OWN + "index.html", HTML);
        add("/nodes", OWN + "nodes.html", HTML);
        add("/style.css", OWN + "style.css", STYLE);
        add("/icon.svg", OWN + "icon.svg", ICON);
        for (String script : OwnScripts.NAMES) {
            add("/" + script, OWN + script, SCRIPT);
        }
        add("/three/three.module.js", THREE + "build/three.module.min.js", SCRIPT);
        add("/three/three.core.min.js", THREE + "build/three.core.min.js", SCRIPT);
        add("/three/OrbitControls.js", THREE + "examples/jsm/controls/OrbitControls.js", SCRIPT);
        add("/uplot/uPlot.js", UPLOT + "dist/uPlot.esm.js", SCRIPT);
        add("/uplot/uPlot.css", UPLOT + "dist/uPlot.min.css", STYLE);
        policy =
                "default-src 'none'; script-src 'self' 'sha256-"
                        + importMapHash()
                        + "'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self';"
                        + " base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
    }

    private void add(String path, String resource, String type) {
        try (InputStream in = PageFiles.class.getClassLoader().getResourceAsStream(resource)) {
            if (in == null) {
                throw new IllegalStateException("no jar contains " + resource);
            }
            byte[] bytes = in.readAllBytes();
            String tag = "\"" + HexFormat.of().formatHex(sha256(bytes), 0, 12) + "\"";
            files.put(path, new Page(bytes, type, tag));
        } catch (IOException e) {
            throw new UncheckedIOException(e);
        }
    }

    /** Returns the hash of the inline import map, which the content security policy must permit. */
    private String importMapHash() {
        Page index = files.get("/");
        Matcher map = INLINE.matcher(new String(index.bytes, StandardCharsets.UTF_8));
        if (!map.find()) {
            throw new IllegalStateException("the page has no import map");
        }
        return Base64.getEncoder()
                .encodeToString(sha256(map.group(1).getBytes(StandardCharsets.UTF_8)));
    }

    private static byte[] sha256(byte[] bytes) {
        try {
            return MessageDigest.getInstance("SHA-256").digest(bytes);
        } catch (NoSuchAlgorithmException e) {
            throw new AssertionError("every Java platform has SHA-256", e);
        }
    }

    @Override
    public boolean handle(Request request, Response response, Callback callback) {
        boolean head = HttpMethod.HEAD.is(request.getMethod());
        if (!head && !HttpMethod.GET.is(request.getMethod())) {
            Response.writeError(
                    request, response, callback, HttpStatus.METHOD_NOT_ALLOWED_405, "GET only");
            return true;
        }
        Page file = files.get(Request.getPathInContext(request));
        if (file == null) {
            Response.writeError(request, response, callback, HttpStatus.NOT_FOUND_404);
            return true;
        }
        var headers = response.getHeaders();
        headers.put("Content-Security-Policy", policy);
        headers.put("X-Content-Type-Options", "nosniff");
        headers.put("Referrer-Policy", "no-referrer");
        headers.put("Cross-Origin-Opener-Policy", "same-origin");
        headers.put("Cross-Origin-Resource-Policy", "same-origin");
        headers.put(HttpHeader.CACHE_CONTROL, "no-cache");
        headers.put(HttpHeader.ETAG, file.tag);
        headers.put(HttpHeader.CONTENT_TYPE, file.type);
        if (file.tag.equals(request.getHeaders().get(HttpHeader.IF_NONE_MATCH))) {
            response.setStatus(HttpStatus.NOT_MODIFIED_304);
            callback.succeeded();
            return true;
        }
        headers.put(HttpHeader.CONTENT_LENGTH, file.bytes.length);
        response.write(true, head ? null : ByteBuffer.wrap(file.bytes), callback);
        return true;
    }
}
