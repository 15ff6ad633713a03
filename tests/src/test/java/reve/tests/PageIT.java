// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import tools.jackson.databind.JsonNode;

import java.net.URI;
import java.nio.file.Files;
import java.nio.file.Path;

/**
 * The page of {@code serve --web} in a headless Chromium, used through its panels. Pictures of each
 * test are in build/reports/page.
 */
@Tag("slow")
class PageIT {
    private static final Path PICTURES = Project.ROOT.resolve("build/reports/page");
    private static final String OPEN =
            "document.body.dataset.state === 'open' && reve.view.frame > 0";

    @TempDir private Path folder;

    private Browser browser;

    @BeforeEach
    void startBrowser() throws Exception {
        browser = new Browser(Files.createDirectory(folder.resolve("profile")), 1360, 820);
    }

    @AfterEach
    void closeBrowser() {
        browser.close();
    }

    private String open(Server server) throws Exception {
        JsonNode ready = server.events().await("ready", any -> true);
        String page = ready.get("web").asString();
        browser.open(page);
        return page;
    }

    @Test
    void aPersonWatchesChangesLawsAndRewinds() throws Exception {
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        "worlds/spring-orbit",
                        "--port",
                        "0",
                        "--web",
                        "0",
                        "--json")) {
            String page = open(server);
            browser.await(OPEN);

            // Tests the search and the four aspects, which change with the world and have units.
            browser.await("document.querySelectorAll('#found li').length === 5");
            browser.click("#search");
            browser.type("blu");
            browser.await("document.querySelectorAll('#found li').length === 1");
            browser.press("Enter", "Enter", 13);
            browser.await("document.querySelector('#item-name')?.textContent === 'blue'");
            String location =
                    "[...document.querySelectorAll('#aspects tr')].find(r => r.firstChild.textContent === 'location').children[1].textContent";
            browser.await(location + " !== ''");
            String before = browser.ask(location).asString();
            browser.await(location + " !== '" + before + "'");
            assertThat(browser.text("#aspects"))
                    .contains("mass", "kg", "velocity", "m/s", "push", "N*s", "#3498db", "lively");
            browser.picture(PICTURES.resolve("item.png"));

            // Loads a law, which gets its line in the ledger, and later unloads it.
            browser.click("#tab-laws");
            browser.await("document.querySelectorAll('#law-list > section').length === 2");
            assertThat(browser.text("#law-list")).contains("Hooke", "F₁ =", "velocity", "[m/s]");
            browser.click("#ledger-on");
            browser.await("document.querySelectorAll('#ledger tbody tr').length > 2");
            browser.choose("#law-choice", "gravity_field");
            browser.click("#law-load");
            browser.await(
                    "document.querySelector('#law-list > section[data-library=gravity_field]')");
            browser.await(
                    "[...document.querySelectorAll('#ledger tbody tr')].some(r => r.firstChild.textContent"
                            + " === 'gravity_field' && r.children[1].textContent !== '0')");
            // Tests the time of the law in a frame, and a budget for the law.
            browser.await(
                    "document.querySelector('[data-library=gravity_field]').textContent.includes('ms per"
                            + " frame (p99 ')");
            browser.ask(
                    "(() => { const field = document.querySelector('#budget-gravity_field');"
                            + " field.value = '5'; field.dispatchEvent(new Event('change')); })()");
            browser.await(
                    "reve.connection.report('laws').then(r => r.loaded.find(l => l.library ==="
                            + " 'gravity_field').budget?.milliseconds === 5)");
            browser.picture(PICTURES.resolve("laws.png"));
            server.events()
                    .await(
                            "law-loaded",
                            law -> law.get("library").asString().equals("gravity_field"));

            // Edits the gravity of the running world, which is a property of the item world.
            browser.ask("reve.select(reve.view.byName.get('world').slot)");
            browser.await("document.querySelector('[aria-label=\"Edit gravity\"]')");
            browser.click("[aria-label=\"Edit gravity\"]");
            browser.ask("document.activeElement.select()");
            browser.type("0, -9.81, 0");
            browser.press("Enter", "Enter", 13);
            browser.await(
                    "reve.connection.report('inspect', {item: 'world'}).then(r => r.physics.find(p => p.name === 'gravity').value[1] === -9.81)");

            browser.click("#tab-laws");
            browser.click("[aria-label=\"Unload gravity_field\"]");
            browser.await(
                    "!document.querySelector('#law-list > section[data-library=gravity_field]')");

            // Tests pause, step, run, speed, an image, and rewinds.
            browser.click("#play");
            browser.await("document.querySelector('#status').textContent === 'paused'");
            browser.await(
                    "reve.transport.state.paused && reve.transport.state.frames === reve.view.frame");
            long paused = browser.ask("reve.view.frame").asLong();
            browser.click("#step");
            browser.await("reve.view.frame === " + (paused + 1));
            browser.click("#rewind");
            browser.await("reve.view.time < 0.05");
            browser.click("#play");
            browser.await("document.querySelector('#status').textContent === 'running'");
            browser.choose("#speed", "0.25");
            browser.await("document.querySelector('#status').textContent === 'running at 0.25×'");

            // Joins with a body, and acts with a form that the page makes from the declaration of
            // the action.
            browser.click("#tab-agents");
            browser.click("#agent-join");
            browser.await("reve.agent?.body === 'visitor' && reve.view.byName.has('visitor')");
            browser.await("document.querySelector('#clients').textContent.includes('visitor')");
            browser.ask("reve.select(reve.view.byName.get('blue').slot)");
            browser.click("#aspects form input");
            browser.type("0, 40, 0");
            browser.click("#aspects form button");
            server.events().await("ready", any -> true);
            browser.await(
                    "[...document.querySelectorAll('#events li')].some(e => e.textContent.includes('pushed'))");
            browser.click("#tab-agents");
            browser.picture(PICTURES.resolve("agents.png"));

            // Tests plots.
            browser.ask("reve.plots.add('blue', 'physics.velocity', 'm/s')");
            browser.await("document.querySelectorAll('.plot canvas').length >= 3");
            browser.await("[...reve.plots.watched.values()][0].plot.data[0].length > 3");
            browser.picture(PICTURES.resolve("plots.png"));
            browser.size(390, 800);
            browser.await("document.querySelector('#side').getBoundingClientRect().top > 200");
            browser.picture(PICTURES.resolve("phone.png"));

            String origin = page.substring(0, page.length() - 1);
            assertThat(browser.requests)
                    .filteredOn(
                            address ->
                                    !address.startsWith("data:") && !address.startsWith("about:"))
                    .allSatisfy(
                            address ->
                                    assertThat(address)
                                            .matches(
                                                    any ->
                                                            any.startsWith(origin)
                                                                    || any.startsWith(
                                                                            origin.replace(
                                                                                    "http",
                                                                                    "ws"))));
            assertThat(browser.errors).isEmpty();
        }
    }

    @Test
    void aLawIsWrittenInThePageAndAnotherIsDroppedOnIt() throws Exception {
        String card = "document.querySelector('#law-list > section[data-library=%s]')";
        try (Server server =
                Server.start(
                        folder, "serve", "worlds/sandbox", "--port", "0", "--web", "0", "--json")) {
            open(server);
            browser.await(OPEN);
            browser.click("#tab-laws");
            browser.await("document.querySelectorAll('#law-list > section').length === 2");
            browser.click("#law-editor summary");

            // The page shows a wrong unit with its place, and nothing changes.
            browser.click("#law-text");
            browser.ask("document.activeElement.select()");
            browser.type("law wind\n  parameter w = (5, 0, 0) m/s\n  each body: force += w");
            browser.click("#law-text-load");
            browser.await("document.querySelector('#law-problems').textContent !== ''");
            assertThat(browser.text("#law-problems")).contains("text:3:", "velocity", "force");
            assertThat(
                            browser.ask(
                                            "(t => t.value.slice(t.selectionStart, t.selectionEnd))(document.querySelector('#law-text'))")
                                    .asString())
                    .contains("each body");
            browser.picture(PICTURES.resolve("law-problem.png"));
            assertThat(browser.ask("Boolean(" + card.formatted("wind") + ")").booleanValue())
                    .isFalse();

            browser.ask("document.querySelector('#law-text').select()");
            browser.type(
                    "law wind\n  parameter w = (5, 0, 0) m/s\n  each body: force += 2 kg/s * (w - velocity)");
            browser.press("Enter", "Enter", 13, 2);
            browser.await(card.formatted("wind"));
            assertThat(browser.text("#law-problems")).isEmpty();
            browser.await(
                    "reve.connection.report('inspect', {item: 'ball-1-1-1'}).then(r => r.physics.find(p => p.name === 'velocity').value[0] > 0.1)");
            assertThat(browser.text("#law-list > section[data-library=wind] .equation"))
                    .contains("2 kg/s * (w - velocity)");
            browser.picture(PICTURES.resolve("law-written.png"));

            // Drops a file on the page. A loaded text appears in the editor again.
            drop("fall.law", "law fall\\n  each body: force += mass (0, -1, 0) m/s^2\\n");
            browser.await(card.formatted("fall"));
            browser.click("[aria-label=\"Edit wind\"]");
            browser.await("document.querySelector('#law-text').value.startsWith('law wind')");
            drop("libvesper_law_x.so", "");
            browser.await(
                    "document.querySelector('#toasts').textContent.includes('libvesper_law_x.so is not a law as text')");
            assertThat(browser.errors).isEmpty();
        }
    }

    @Test
    void theDivergenceOfANewVersionInTheShadowIsPlotted() throws Exception {
        String load =
                "reve.connection.ask('load-law', {library: 'push.law', text: 'law push\\n  each body:"
                        + " force += %d N (1, 0, 0)\\n', swap: 'shadow'}).then(() => true)";
        String trial = "document.querySelector('#law-shadows [data-library=push]%s')";
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        "worlds/sandbox",
                        "--port",
                        "0",
                        "--web",
                        "0",
                        "--json",
                        "--shadow-seconds",
                        "2")) {
            open(server);
            browser.await(OPEN);
            browser.click("#tab-laws");
            browser.ask(load.formatted(1));
            browser.ask(load.formatted(2));
            browser.await(trial.formatted(" polyline.position") + "?.points.length > 3");
            browser.await(trial.formatted(" .chip.good") + "?.textContent === 'accepted'");
            assertThat(browser.text("#law-shadows [data-library=push]"))
                    .contains("120 of 120 frames", "largest difference of position", "ball-");
            // from the lower left to the upper right: the distance grows with the square of time
            assertThat(
                            browser.ask(
                                            "(p => p[p.length - 1].y < p[0].y && p[p.length - 1].x > p[0].x)("
                                                    + "[...document.querySelector('#law-shadows polyline.position').points])")
                                    .booleanValue())
                    .isTrue();
            browser.picture(PICTURES.resolve("law-shadow.png"));

            browser.ask(
                    "reve.connection.ask('load-law', {library: 'wind.law', text: 'law wind\\n "
                            + " parameter f = 1 N\\n  each body: force += f (1, 0, 0)\\n'})"
                            + ".then(() => true)");
            browser.ask(
                    "reve.connection.ask('set-law', {library: 'wind', swap: 'shadow', parameters:"
                            + " {f: 2}}).then(() => true)");
            browser.await(
                    "document.querySelector('#law-shadows [data-library=wind] .parameters')"
                            + "?.textContent === 'f = 2.0'");
            browser.await(
                    trial.replace("push", "wind").formatted(" .chip.good")
                            + "?.textContent === 'accepted'");
            assertThat(browser.errors).isEmpty();
        }
    }

    private void drop(String name, String content) throws Exception {
        browser.ask(
                "(() => { const data = new DataTransfer(); data.items.add(new File(['"
                        + content
                        + "'], '"
                        + name
                        + "')); for (const type of ['dragover', 'drop'])"
                        + " document.body.dispatchEvent(new DragEvent(type, {dataTransfer: data,"
                        + " bubbles: true, cancelable: true})); })()");
    }

    @Test
    void theHeaderOfALawShowsWhereItRunsWhyAndItsBudget() throws Exception {
        Path untrusted = Files.createDirectory(folder.resolve("strangers"));
        Path trusted = Files.createDirectory(folder.resolve("laws"));
        Path tests = Project.NATIVE.resolve("adapter-test-laws");
        Files.copy(tests.resolve("libvesper_law_wind.so"), untrusted.resolve("wind.so"));
        Files.copy(
                tests.resolve("libvesper_law_counts_years.so"), trusted.resolve("counts_years.so"));
        Files.writeString(
                trusted.resolve("pull.law"), "law pull\n  each body: force += 1 N (1, 0, 0)\n");
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        "worlds/sandbox",
                        "--port",
                        "0",
                        "--web",
                        "0",
                        "--json",
                        "--laws",
                        trusted.toString(),
                        "--untrusted",
                        untrusted.toString(),
                        "--weak-sandbox")) {
            open(server);
            browser.await(OPEN);
            browser.click("#tab-laws");
            String header = "#law-list > section[data-library=%s] header .standing";
            for (String law : java.util.List.of("wind", "counts_years", "pull", "newton_motion")) {
                browser.await("document.querySelector('" + header.formatted(law) + "')");
            }
            assertThat(browser.text(header.formatted("wind")))
                    .isEqualTo("sandboxnot trustedno budget");
            assertThat(browser.text(header.formatted("counts_years")))
                    .isEqualTo("enginetrustedno budget");
            assertThat(browser.text(header.formatted("pull"))).isEqualTo("enginetextno budget");
            assertThat(browser.text(header.formatted("newton_motion")))
                    .isEqualTo("engineshippedno budget");
            browser.ask(
                    "reve.connection.ask('set-budget', {library: 'wind', milliseconds: 2.5, then:"
                            + " 'unload'}).then(() => true)");
            browser.await(
                    "document.querySelector('"
                            + header.formatted("wind")
                            + " .allowed')?.textContent === 'budget 2.5 ms, then unload'");
            browser.ask(
                    "document.querySelector('#law-list > section[data-library=wind]').scrollIntoView()");
            browser.picture(PICTURES.resolve("law-headers.png"));
            assertThat(browser.errors).isEmpty();
        }
    }

    @Test
    void aLawThatFailsIsShownInQuarantine() throws Exception {
        Path laws = Files.createDirectory(folder.resolve("laws"));
        Path source =
                Files.writeString(
                        folder.resolve("broken.cpp"),
                        """
                        #include <limits>
                        #include "vesper/law.hpp"
                        using namespace vesper;
                        template <class Real>
                        struct Broken {
                          static constexpr auto kName = "broken", kVersion = "1.0.0", kDoc = "Fails.";
                          static constexpr auto kPhase = Phase::kForce;
                          Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};
                          auto Properties() { return std::tie(force); }
                          void Advance(const Step&) {
                            for (uint64_t i = 0; i < force.size(); ++i)
                              force[i] += Vec3<Real>{std::numeric_limits<Real>::quiet_NaN(), 0, 0};
                          }
                        };
                        VESPER_LAW_LIBRARY("broken", Broken)
                        """);
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        "worlds/spring-orbit",
                        "--port",
                        "0",
                        "--web",
                        "0",
                        "--json",
                        "--laws",
                        laws.toString())) {
            open(server);
            browser.await(OPEN);
            Path built = folder.resolve("libvesper_law_broken.so");
            Reve.Outcome compiled =
                    Reve.run(
                            java.util.List.of(
                                    "g++",
                                    "-std=c++20",
                                    "-O1",
                                    "-shared",
                                    "-fPIC",
                                    "-I" + Project.ROOT.resolve("vesper-native/include"),
                                    source.toString(),
                                    "-o",
                                    built.toString()));
            assertThat(compiled.code()).as(compiled.err()).isZero();
            Files.move(built, laws.resolve("libvesper_law_broken.so"));
            browser.await("document.querySelector('#law-quarantine .card.bad')");
            assertThat(browser.text("#law-quarantine")).contains("broken", "externalForce", "nan");
            browser.click("#tab-laws");
            browser.picture(PICTURES.resolve("quarantine.png"));
            long frame = browser.ask("reve.view.frame").asLong();
            browser.await("reve.view.frame > " + (frame + 30));
        }
    }

    @Test
    void thePageReconnectsToARestartedServer() throws Exception {
        String[] command = {"serve", "worlds/spring-orbit", "--port", "0", "--json", "--web", "0"};
        String page;
        try (Server server = Server.start(folder, command)) {
            page = open(server);
            browser.await(OPEN);
        }
        browser.await("document.querySelector('#status').textContent === 'reconnecting…'");
        command[command.length - 1] = String.valueOf(URI.create(page).getPort());
        try (Server server = Server.start(folder, command)) {
            server.events().await("ready", any -> true);
            browser.await(
                    OPEN
                            + " && reve.view.time < 60 && document.querySelector('#status').textContent === 'running'");
            browser.await("document.querySelectorAll('#found li').length === 5");
        }
    }

    @Test
    void aTokenIsEnteredInThePageAndStandsNowhereElse() throws Exception {
        Path tokens = folder.resolve("tokens.json");
        Reve.Outcome made =
                Reve.runAsProcess(
                        "token", "new", "ada", "--file", tokens.toString(), "--roles", "control");
        assertThat(made.code()).as(made.err()).isZero();
        String token =
                java.util.regex.Pattern.compile("[0-9a-f]{32}")
                        .matcher(made.out())
                        .results()
                        .findFirst()
                        .orElseThrow()
                        .group();
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        "worlds/spring-orbit",
                        "--port",
                        "0",
                        "--web",
                        "0",
                        "--json",
                        "--tokens",
                        tokens.toString())) {
            open(server);
            browser.await("document.querySelector('#join').open");
            assertThat(browser.text("#join-why")).contains("with a token");
            assertThat(browser.ask("reve.view.frame").asLong()).isZero();
            enter("ada", "0".repeat(32));
            browser.await("document.querySelector('#join').open");
            browser.picture(PICTURES.resolve("join.png"));
            enter("ada", token);
            browser.await(OPEN);
            assertThat(browser.ask("location.href").asString()).doesNotContain(token);
            assertThat(
                            browser.ask(
                                            "JSON.stringify(localStorage) + JSON.stringify(sessionStorage) + document.cookie")
                                    .asString())
                    .doesNotContain(token);
            assertThat(browser.requests)
                    .allSatisfy(address -> assertThat(address).doesNotContain(token));
            server.process().toHandle().destroy();
            assertThat(server.events().untilEnd().toString()).doesNotContain(token);
        }
        assertThat(Files.readString(folder.resolve("server.err"))).doesNotContain(token);
    }

    private void enter(String name, String token) throws Exception {
        browser.ask(
                "document.querySelector('#join-name').value = '"
                        + name
                        + "'; document.querySelector('#join-token').value = '"
                        + token
                        + "'; document.querySelector('#join-go').click()");
    }

    @Test
    void twoThousandItemsAreShown() throws Exception {
        Path world =
                Files.writeString(
                        folder.resolve("many.yaml"),
                        """
                        reve: 1
                        name: many
                        laws: [gravity_field, newton_motion]
                        constants: {gravity: [0, -0.01, 0]}
                        items:
                          - name: ball-{x}-{y}-{z}
                            repeat: {x: 20, y: 10, z: 10}
                            physical: {shape: sphere, radius: 0.3, location: "{[x, y + 2, z]}", colour: "#e67e22"}
                            physics: {mass: 1 kg}
                        """);
        try (Server server =
                Server.start(
                        folder, "serve", world.toString(), "--port", "0", "--web", "0", "--json")) {
            browser.size(640, 400); // drawn by the processor
            open(server);
            browser.await(OPEN);
            browser.await("reve.view.items.filter(i => i?.shape === 1).length === 2000");
            browser.await(
                    "reve.scene.groups.size === 1 && [...reve.scene.groups.values()][0].mesh.count === 2000");
            long frame = browser.ask("reve.view.frame").asLong();
            browser.await("reve.view.frame > " + (frame + 5));
            browser.picture(PICTURES.resolve("many.png"));
            assertThat(browser.errors).isEmpty();
        }
    }
}
