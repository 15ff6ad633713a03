// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.Join;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.net.URI;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;

/**
 * The page of the nodes of a cluster in a headless Chromium, with two nodes. Pictures of the test
 * are in build/reports/page.
 */
@Tag("slow")
class NodesPageIT {
    private static final Path PICTURES = Project.ROOT.resolve("build/reports/page");
    private static final int SLEEP_AFTER_SECONDS = 30;

    @TempDir private Path folder;

    private final List<Server> servers = new ArrayList<>();
    private Postgres postgres;
    private String url;
    private Browser browser;

    /**
     * @param address where other nodes reach it
     * @param web address of its page of the nodes
     * @param agents its port for agents
     */
    private record Node(Server server, String address, String web, int agents) {}

    @BeforeEach
    void start() throws Exception {
        postgres = new Postgres();
        url = postgres.create("nodes");
        browser = new Browser(Files.createDirectory(folder.resolve("profile")), 1280, 820);
    }

    @AfterEach
    void end() throws Exception {
        browser.close();
        servers.forEach(Server::close);
        postgres.close();
    }

    private Node node(String... more) throws IOException {
        List<String> arguments =
                new ArrayList<>(
                        List.of(
                                "serve",
                                "--cluster",
                                "lab",
                                "--port",
                                "0",
                                "--web",
                                "0",
                                "--json",
                                "--sleep-after",
                                Integer.toString(SLEEP_AFTER_SECONDS),
                                "--store",
                                url));
        arguments.addAll(List.of(more));
        Server server =
                Server.start(
                        Files.createDirectory(folder.resolve("node" + servers.size())),
                        arguments.toArray(String[]::new));
        servers.add(server);
        JsonNode starts =
                server.events()
                        .await(
                                "cluster",
                                event -> event.path("status").asString().equals("starts"));
        return new Node(
                server,
                starts.path("node").asString(),
                starts.path("web").asString(),
                starts.path("agentPort").asInt());
    }

    private Path world(String name) throws IOException {
        Path file = folder.resolve(name + ".yaml");
        String sample = Files.readString(Project.WORLDS.resolve("spring-orbit/world.yaml"));
        return Files.writeString(
                file,
                sample.replace("name: spring-orbit", "name: " + name)
                        .replace("rate: 60, steps: 4", "rate: 20, steps: 12"));
    }

    /** Returns an expression for the text of a row of a table. */
    private static String row(String kind, String name) {
        return "(document.querySelector('[data-"
                + kind
                + "=\""
                + name
                + "\"]')?.textContent ?? '')";
    }

    private static AgentClient watcher(Node node, String world) throws IOException {
        return Agents.join(
                node.agents(),
                Join.as("watcher-of-" + world).withRole("observer").withWorld(world));
    }

    private static String logged(String text) {
        return "[...document.querySelectorAll('#moves li')].some(line => line.textContent.includes('"
                + text
                + "'))";
    }

    /** Opens the page of a world, again if its node has not read the newest orders yet. */
    private void openWorld(String page) throws Exception {
        boolean isOpen = false;
        for (int attempt = 0; attempt < 30 && !isOpen; attempt++) {
            browser.open(page);
            browser.await("['open', 'closed'].includes(document.body?.dataset.state)");
            isOpen = browser.ask("document.body.dataset.state === 'open'").booleanValue();
        }
        browser.await("document.body.dataset.state === 'open' && reve.view.frame > 0");
    }

    /**
     * An operator opens the page, sees worlds run on their nodes, moves one, opens it in the page
     * of its new node, sees the other one fall asleep, wakes it, and drains a node.
     */
    @Test
    void anOperatorSeesWhereWorldsRunAndMovesThem() throws Exception {
        Node first = node();
        Node second =
                node("--seed", first.address(), world("w1").toString(), world("w2").toString());
        try (AgentClient _ = watcher(second, "w1");
                AgentClient _ = watcher(second, "w2")) { // they keep the worlds awake
            assertThat(first.web()).endsWith("/nodes");
            browser.open(first.web());
            browser.await("document.body.dataset.state === 'open'");
            browser.await("document.querySelectorAll('#nodes tr').length === 2");
            browser.await(row("node", first.address()) + ".includes('(this one)')");
            browser.await(row("node", second.address()) + ".includes('up')");
            browser.await("document.querySelectorAll('#worlds .chip.good').length === 2");
            assertThat(browser.text("#cluster")).isEqualTo("lab");
            assertThat(browser.text("#totals")).contains("2 nodes", "2 worlds: 2 run, 0 sleep");
            browser.await(
                    "nodes.state.nodes.every(node => node.memory > 0 && node.memory < 1 && node.cpu >= 0"
                            + " && node.cpu <= 1 && node.clients >= 0)");
            JsonNode frame = browser.ask("nodes.state.worlds[0].frame");
            browser.await("nodes.state.worlds[0].frame > " + frame.asLong());
            browser.picture(PICTURES.resolve("nodes.png"));
        }

        // Moves w1 to the other node with the list in its row.
        String place = "nodes.state.worlds.find(world => world.world === 'w1').node";
        String from = browser.ask(place).asString();
        String to = from.equals(first.address()) ? second.address() : first.address();
        browser.choose("[data-world=w1] select", to);
        browser.await(place + " === '" + to + "'");
        browser.await(logged("world w1: from " + from + " to " + to));
        browser.await(row("world", "w1") + ".includes('" + to + " (ordered)')");

        // Opens w1 on the page of its new node, where its items are drawn. It stays awake there.
        Node owner = to.equals(first.address()) ? first : second;
        String link = browser.ask("document.querySelector('[data-world=w1] a').href").asString();
        assertThat(link)
                .isEqualTo(owner.web().replaceAll("nodes$", "") + "?world=w1")
                .doesNotContain(URI.create(owner.web()).getPath());
        openWorld(link);
        browser.await("reve.view.byName.has('red')");
        assertThat(browser.text("#world")).isEqualTo("w1");

        // Both worlds fall asleep without a client; the page of the nodes is none.
        try (AgentClient _ = watcher(owner, "w1")) { // so that the page sees it fall asleep
            browser.open(second.web());
            browser.await("document.querySelectorAll('#worlds tr').length === 2");
            browser.await("!" + row("world", "w1") + ".includes('asleep')");
        }
        browser.await(row("world", "w1") + ".includes('asleep')");
        browser.await(row("world", "w2") + ".includes('asleep')");
        browser.await("document.querySelector('#totals').textContent.includes('0 run, 2 sleep')");
        browser.await(logged("world w1: sleeps at frame"));
        browser.picture(PICTURES.resolve("nodes-asleep.png"));

        // A drained node runs no worlds, so w2 wakes on the other one.
        browser.click("[data-node=\"" + first.address() + "\"] button");
        browser.await(row("node", first.address()) + ".includes('drained')");
        browser.click("[data-node=\"" + second.address() + "\"] button");
        browser.await(
                "document.querySelector('#toasts .bad')?.textContent.includes('no other node than "
                        + second.address()
                        + " can run worlds')");
        openWorld(second.web().replaceAll("nodes$", "") + "?world=w2");
        browser.open(first.web());
        browser.await(
                "nodes.state.worlds.find(world => world.world === 'w2').node === '"
                        + second.address()
                        + "'");
        browser.ask(
                "(() => { const filter = document.querySelector('#filter'); filter.value = 'W2';"
                        + " filter.dispatchEvent(new Event('input')); })()");
        browser.await("document.querySelectorAll('#worlds tr').length === 1");
        browser.click("[data-node=\"" + first.address() + "\"] button");
        browser.await("!" + row("node", first.address()) + ".includes('drained')");

        // A node is lost.
        Node lost = first;
        browser.open(second.web());
        browser.await(row("node", lost.address()) + ".includes('up')");
        lost.server().close();
        browser.await(logged("node " + lost.address() + ": has left the cluster"));
        browser.await("document.querySelectorAll('#nodes tr').length === 1");
        assertThat(browser.errors).isEmpty();
        assertThat(browser.requests)
                .allMatch(
                        request ->
                                request.startsWith("http://127.0.0.1:")
                                        || request.startsWith("ws://127.0.0.1:")
                                        || request.startsWith("data:")
                                        || request.startsWith("blob:"));
    }

    /** The page of a world at a node that watches shows the world of another node. */
    @Test
    void aPageAtANodeThatWatchesShowsTheWorld() throws Exception {
        Node owner = node(world("w1").toString());
        Node watching = node("--seed", owner.address(), "--watch");
        browser.open(watching.web());
        browser.await("document.body.dataset.state === 'open'");
        browser.await(row("node", watching.address()) + ".includes('watches')");
        browser.await("nodes.state.worlds.some(world => world.node === '" + owner.address() + "')");
        assertThat(
                        browser.ask(
                                        "document.querySelector('[data-node=\""
                                                + watching.address()
                                                + "\"] button').hidden")
                                .booleanValue())
                .as("a node without worlds is not drained")
                .isTrue();
        openWorld(watching.web().replaceAll("nodes$", "") + "?world=w1");
        assertThat(browser.ask("reve.role").asString()).isEqualTo("observer");
        browser.await("reve.view.byName.has('blue')");
        long shown = browser.ask("reve.view.frame").asLong();
        browser.await("reve.view.frame > " + (shown + 20));
        browser.picture(PICTURES.resolve("watching.png"));
        browser.click("#tab-laws");
        browser.await("document.querySelector('#panel-laws').textContent.includes('only watches')");
        browser.picture(PICTURES.resolve("watching-laws.png"));
        assertThat(browser.errors).isEmpty();
    }
}
