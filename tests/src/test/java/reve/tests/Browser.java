// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;
import tools.jackson.databind.node.ObjectNode;

import java.io.BufferedReader;
import java.io.IOException;
import java.net.URI;
import java.net.http.HttpClient;
import java.net.http.HttpRequest;
import java.net.http.HttpResponse;
import java.net.http.WebSocket;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Base64;
import java.util.List;
import java.util.Map;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.CompletionStage;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.ExecutionException;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.TimeoutException;
import java.util.concurrent.locks.LockSupport;

/**
 * A headless Chromium with one page, driven over the DevTools protocol. It keeps the requests and
 * the errors of the page.
 */
final class Browser implements AutoCloseable, WebSocket.Listener {
    private static final JsonMapper JSON = new JsonMapper();
    private static final long PATIENCE_SECONDS = 300;
    private static final int CLICKS = 5;
    private static final String LISTENING = "DevTools listening on ";

    private final Process process;
    private final HttpClient http = HttpClient.newHttpClient();
    private final WebSocket socket;
    private final Map<Integer, CompletableFuture<JsonNode>> answers = new ConcurrentHashMap<>();
    private final StringBuilder part = new StringBuilder();
    private int lastId;

    /** Addresses that the page has requested. */
    final ConcurrentLinkedQueue<String> requests = new ConcurrentLinkedQueue<>();

    /** Exceptions and errors that the page has reported. */
    final ConcurrentLinkedQueue<String> errors = new ConcurrentLinkedQueue<>();

    /**
     * @param profile an empty folder
     */
    Browser(Path profile, int width, int height) throws Exception {
        List<String> command =
                new ArrayList<>(
                        List.of(
                                "chromium",
                                "--headless=new",
                                "--disable-background-networking",
                                "--no-first-run",
                                "--use-angle=swiftshader",
                                "--enable-unsafe-swiftshader",
                                "--disable-dev-shm-usage",
                                "--remote-debugging-port=0",
                                "--user-data-dir=" + profile,
                                "--window-size=" + width + "," + height));
        if (System.getProperty("user.name").equals("root")) {
            command.add("--no-sandbox");
        }
        command.add("about:blank");
        ProcessBuilder builder = new ProcessBuilder(command);
        builder.environment().put("TMPDIR", profile.toString()); // it leaves folders there
        process = builder.start();
        String address = address(process.errorReader());
        String page = "";
        for (int i = 0; i < 600 && page.isEmpty(); i++) { // until the first tab is open
            page = page(address);
            LockSupport.parkNanos(100_000_000);
        }
        socket = http.newWebSocketBuilder().buildAsync(URI.create(page), this).join();
        send("Runtime.enable", JSON.createObjectNode());
        send("Log.enable", JSON.createObjectNode());
        send("Network.enable", JSON.createObjectNode());
        send("Page.enable", JSON.createObjectNode());
        size(width, height);
    }

    /** Returns the address of the first tab; empty if none is open. */
    private String page(String browser) throws IOException, InterruptedException {
        HttpResponse<String> targets =
                http.send(
                        HttpRequest.newBuilder(
                                        URI.create(
                                                "http://"
                                                        + URI.create(browser).getAuthority()
                                                        + "/json"))
                                .build(),
                        HttpResponse.BodyHandlers.ofString());
        for (JsonNode target : JSON.readTree(targets.body())) {
            if (target.get("type").asString().equals("page")) {
                return target.get("webSocketDebuggerUrl").asString();
            }
        }
        return "";
    }

    private static String address(BufferedReader output) throws IOException {
        for (String line = output.readLine(); line != null; line = output.readLine()) {
            if (line.startsWith(LISTENING)) {
                Thread.ofVirtual().start(() -> output.lines().forEach(_ -> {}));
                return line.substring(LISTENING.length()).strip();
            }
        }
        throw new IOException("chromium ended at its start");
    }

    @Override
    public void onOpen(WebSocket opened) {
        opened.request(1);
    }

    @Override
    public CompletionStage<?> onText(WebSocket from, CharSequence text, boolean last) {
        part.append(text);
        if (last) {
            JsonNode message = JSON.readTree(part.toString());
            part.setLength(0);
            if (message.has("id")) {
                answers.remove(message.get("id").asInt()).complete(message);
            } else {
                note(message.path("method").asString(""), message.path("params"));
            }
        }
        from.request(1);
        return null;
    }

    private void note(String method, JsonNode event) {
        switch (method) {
            case "Network.requestWillBeSent" -> requests.add(event.at("/request/url").asString(""));
            case "Network.webSocketCreated" -> requests.add(event.path("url").asString(""));
            case "Runtime.exceptionThrown" ->
                    errors.add(event.at("/exceptionDetails/exception/description").asString("?"));
            case "Runtime.consoleAPICalled" -> {
                if (event.path("type").asString("").equals("error")) {
                    errors.add(event.path("args").toString());
                }
            }
            case "Log.entryAdded" -> {
                if (event.at("/entry/source").asString("").equals("security")) {
                    errors.add(event.at("/entry/text").asString(""));
                }
            }
            default -> {}
        }
    }

    private JsonNode send(String method, ObjectNode parameters) throws Exception {
        int id = ++lastId;
        var answer = new CompletableFuture<JsonNode>();
        answers.put(id, answer);
        ObjectNode message = JSON.createObjectNode().put("id", id).put("method", method);
        message.set("params", parameters);
        socket.sendText(message.toString(), true).join();
        try {
            return answer.get(PATIENCE_SECONDS, TimeUnit.SECONDS);
        } catch (TimeoutException | ExecutionException e) {
            throw new AssertionError(method + " was not answered; the page reported " + errors, e);
        }
    }

    void size(int width, int height) throws Exception {
        send(
                "Emulation.setDeviceMetricsOverride",
                JSON.createObjectNode()
                        .put("width", width)
                        .put("height", height)
                        .put("deviceScaleFactor", 1)
                        .put("mobile", false));
    }

    void open(String address) throws Exception {
        send("Page.navigate", JSON.createObjectNode().put("url", address));
    }

    /** Evaluates an expression in the page. If the result is a promise, waits for it. */
    JsonNode ask(String expression) throws Exception {
        JsonNode answer =
                send(
                        "Runtime.evaluate",
                        JSON.createObjectNode()
                                .put("expression", expression)
                                .put("awaitPromise", true)
                                .put("returnByValue", true));
        if (answer.at("/result").has("exceptionDetails")) {
            throw new IllegalStateException(
                    expression + ": " + answer.at("/result/exceptionDetails"));
        }
        return answer.at("/result/result/value");
    }

    /** Waits until an expression is true in the page. */
    void await(String expression) throws Exception {
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(PATIENCE_SECONDS);
        String last = "";
        while (System.nanoTime() < end) {
            try {
                if (ask("Promise.resolve(" + expression + ").then(Boolean)").booleanValue()) {
                    return;
                }
            } catch (IllegalStateException notYet) {
                last = String.valueOf(notYet.getMessage());
            }
            Thread.sleep(50);
        }
        throw new AssertionError(
                "never true in the page: " + expression + "; " + last + "; errors: " + errors);
    }

    /**
     * Clicks the middle of an element with the mouse. Repeats a click that does not reach the
     * element: the page may move the element after it has told where the element is.
     */
    void click(String selector) throws Exception {
        await("document.querySelector('" + selector + "')");
        for (int attempt = 0; attempt < CLICKS; attempt++) {
            JsonNode at =
                    ask(
                            "(() => { const e = document.querySelector('"
                                    + selector
                                    + "'); window.clickArrived = false;"
                                    + " addEventListener('click', c => { clickArrived ="
                                    + " Boolean(c.target.closest('"
                                    + selector
                                    + "')); }, {capture: true, once: true});"
                                    + " e.scrollIntoView({block: 'center'}); const b ="
                                    + " e.getBoundingClientRect(); return [b.left + b.width / 2,"
                                    + " b.top + b.height / 2]; })()");
            for (String type : List.of("mousePressed", "mouseReleased")) {
                send(
                        "Input.dispatchMouseEvent",
                        JSON.createObjectNode()
                                .put("type", type)
                                .put("x", at.get(0).asDouble())
                                .put("y", at.get(1).asDouble())
                                .put("button", "left")
                                .put("clickCount", 1));
            }
            if (ask("window.clickArrived ?? true").booleanValue()) {
                return;
            }
        }
        throw new AssertionError(
                CLICKS + " clicks did not reach " + selector + "; errors: " + errors);
    }

    /** Types a text into the focused element. */
    void type(String text) throws Exception {
        send("Input.insertText", JSON.createObjectNode().put("text", text));
    }

    /** Presses and releases a key. */
    void press(String key, String code, int number) throws Exception {
        press(key, code, number, 0);
    }

    /**
     * Presses and releases a key.
     *
     * @param modifiers 2 for Ctrl, as in the Chrome DevTools protocol
     */
    void press(String key, String code, int number, int modifiers) throws Exception {
        for (String type : List.of("rawKeyDown", "keyUp")) {
            send(
                    "Input.dispatchKeyEvent",
                    JSON.createObjectNode()
                            .put("type", type)
                            .put("key", key)
                            .put("modifiers", modifiers)
                            .put("code", code)
                            .put("windowsVirtualKeyCode", number));
        }
    }

    /** Chooses an option of a select element. */
    void choose(String selector, String value) throws Exception {
        ask(
                "(() => { const s = document.querySelector('"
                        + selector
                        + "'); s.value = '"
                        + value
                        + "'; s.dispatchEvent(new Event('change', {bubbles: true})); })()");
    }

    String text(String selector) throws Exception {
        return ask("document.querySelector('" + selector + "').textContent").asString();
    }

    void picture(Path file) throws Exception {
        JsonNode answer =
                send("Page.captureScreenshot", JSON.createObjectNode().put("format", "png"));
        Files.createDirectories(file.getParent());
        Files.write(file, Base64.getDecoder().decode(answer.at("/result/data").asString()));
    }

    @Override
    public void close() {
        socket.abort();
        http.shutdownNow();
        process.descendants().forEach(ProcessHandle::destroyForcibly);
        process.destroyForcibly();
        process.onExit().join();
    }
}
