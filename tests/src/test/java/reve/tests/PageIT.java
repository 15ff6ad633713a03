// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;
import static org.assertj.core.api.Assertions.withinPercentage;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.Join;

import tools.jackson.databind.JsonNode;

import java.awt.image.BufferedImage;
import java.net.URI;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Map;

import javax.imageio.ImageIO;

/**
 * The page of {@code serve --web} in a headless Chromium, used through its panels. Pictures of each
 * test are in build/reports/page.
 */
@Tag("slow")
class PageIT {
    private static final Path PICTURES = Project.ROOT.resolve("build/reports/page");
    private static final String OPEN =
            "document.body.dataset.state === 'open' && reve.view.frame > 0";

    /** The pairs of parts of the bar that touch each other, and the parts outside the window. */
    private static final String COVERED =
            """
            (() => {
              const parts = [...document.querySelectorAll('#bar img, #bar h1, #transport, #clock,'
                  + ' #status, #sound, #theme')].map(e => [e.id || e.tagName, e.getBoundingClientRect()])
                  .filter(([, r]) => r.width > 0);
              const found = parts.filter(([, r]) => r.left < 0 || r.right > innerWidth)
                  .map(([name]) => name + ' is outside');
              parts.forEach(([a, r], i) => parts.slice(i + 1).forEach(([b, s]) => {
                if (r.left < s.right + 2 && s.left < r.right + 2 && r.top < s.bottom && s.top < r.bottom)
                  found.push(a + ' touches ' + b);
              }));
              return found.join(', ');
            })()
            """;

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
            browser.ask("document.querySelector('#search').select()");
            browser.type("LIVELY");
            browser.await("document.querySelector('#found').textContent === 'bluetemper: lively'");
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
            browser.await(
                    "/^[0-9.]+(e-[0-9]+)? ms$/.test(document.querySelector('[data-client=visitor]"
                            + " td.number').textContent)");
            browser.ask("reve.select(reve.view.byName.get('blue').slot)");
            browser.click("#aspects form input");
            browser.type("0, 40, 0");
            browser.click("#aspects form button");
            server.events().await("ready", any -> true);
            browser.await(
                    "[...document.querySelectorAll('#events li')].some(e => e.textContent.includes('pushed'))");
            browser.click("#tab-agents");
            browser.picture(PICTURES.resolve("agents.png"));

            // This world does not measure contact forces, so they cannot sound.
            browser.click("#sound");
            browser.await(
                    "document.querySelector('#toasts').textContent.includes('does not measure contact"
                            + " forces')");
            browser.click("#sound");

            // Tests plots.
            browser.ask("reve.plots.add('blue', 'physics.velocity', 'm/s')");
            browser.await("document.querySelectorAll('.plot canvas').length >= 3");
            browser.await("[...reve.plots.watched.values()][0].plot.data[0].length > 3");
            browser.picture(PICTURES.resolve("plots.png"));
            for (int width : new int[] {1280, 1121, 1120, 1000, 800, 761, 760, 390}) {
                browser.size(width, 800);
                browser.await("innerWidth === " + width);
                assertThat(browser.ask(COVERED).asString()).as("at %d px", width).isEmpty();
            }
            browser.await("document.querySelector('#side').getBoundingClientRect().top > 200");
            browser.picture(PICTURES.resolve("phone.png"));

            requestsStayAt(page);
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
            String uses =
                    "document.querySelector('#law-list > section[data-library=%s] summary').textContent";
            assertThat(browser.ask(uses.formatted("pull")).asString()).isEqualTo("uses 1 property");
            assertThat(browser.ask(uses.formatted("newton_motion")).asString())
                    .matches("uses [2-9] properties");
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

    /** The camera of each agent looks at a red wall whose front is 4 m away. */
    private static final String STUDIO =
            """
            reve: 1
            name: studio
            agents:
              body:
                physical: {location: [0, 1, 0]}
                sensors:
                  eye: {camera: {size: [64, 48], layers: [colour, depth, items]}, fieldOfView: 60 deg}
                  skin: {range: 2 m}
            items:
              - {name: near, physical: {shape: sphere, radius: 0.2, location: [1, 1, -1]}}
              - {name: far, physical: {shape: sphere, radius: 0.2, location: [1, 1, -9]}}
              - {name: wall, physical: {shape: box, size: [30, 30, 1], location: [0, 1, 4.5], colour: "#cc2200"}}
            """;

    @Test
    void theRoleControlSeesTheAuditRecordAndAsTheAgentItselfPicturesOfItsCamera() throws Exception {
        Path world = Files.writeString(folder.resolve("studio.yaml"), STUDIO);
        browser.size(800, 500); // drawn by the processor
        String button = "[data-client=%1$s] [aria-label=\"Camera eye of %1$s\"]";
        String middle =
                "[...document.querySelector('.picture canvas').getContext('2d').getImageData(32, 24,"
                        + " 1, 1).data]";
        String distance =
                "new Float32Array(Uint8Array.from(atob(reve.agents.pictures.cards.get('%s:"
                        + " eye').image.depth), c => c.charCodeAt(0)).buffer)[24 * 64 + 32]";
        try (Server server =
                        Server.start(
                                folder,
                                "serve",
                                world.toString(),
                                "--port",
                                "0",
                                "--web",
                                "0",
                                "--json",
                                "--audit",
                                folder.resolve("audit.jsonl").toString());
                AgentClient dan = Agents.join(Integer.parseInt(server.port()), Join.as("dan"))) {
            assertThat(dan.welcome().cameras()).containsExactly("eye");
            open(server);
            browser.await(OPEN);
            browser.click("#tab-agents");
            browser.click("#agent-join");
            browser.click(button.formatted("visitor"));
            browser.await(
                    "document.querySelector('.picture canvas').width === 64 && "
                            + middle
                            + "[0] > 100 && "
                            + middle
                            + "[0] > 2 * "
                            + middle
                            + "[1]");
            assertThat(browser.ask(distance.formatted("visitor")).asDouble())
                    .isCloseTo(4, within(1e-3));
            assertThat(browser.text(".picture [role=status]")).contains("64 × 48 px");
            browser.picture(PICTURES.resolve("camera.png"));
            browser.choose(".picture select", "items");
            assertThat(browser.text(".picture [role=status]")).endsWith(": wall");

            // The scene dims what an agent does not perceive.
            dan.perceive();
            browser.click("[aria-label=\"Highlight what dan perceives\"]");
            browser.await(
                    "document.querySelector('#agent-perceives').textContent === 'dan perceives 3"
                            + " items.'");
            assertThat(
                            browser.ask(
                                            "[...reve.scene.highlighted].map(s =>"
                                                    + " reve.view.items[s].name).sort().join()")
                                    .asString())
                    .isEqualTo("dan,near,visitor");
            // The pyramid of each camera has an opening of 60 degrees upwards and 4:3 of its
            // tangent
            // sideways. The reach of the other sensor is a sphere of 2 m.
            browser.ask("document.querySelector('#show-sensors').click()");
            String corners =
                    "(t => reve.scene.sensorLines.geometry.getAttribute('position').array.reduce((all, _,"
                            + " i, p) => all + (i % 3 === 2 && p[i] > 0 && Math.abs(Math.abs(p[i - 2]) /"
                            + " p[i] - t * 4 / 3) < 1e-4 && Math.abs(Math.abs(p[i - 1] - 1) / p[i] - t) <"
                            + " 1e-4), 0))(Math.tan(Math.PI / 6))";
            browser.await(corners + " === 2 * 12");
            assertThat(
                            browser.ask(
                                            "(p => [...Array(p.count).keys()].filter(i =>"
                                                    + " Math.abs(Math.hypot(p.getX(i), p.getY(i) - 1,"
                                                    + " p.getZ(i)) - 2) <"
                                                    + " 1e-4).length)(reve.scene.sensorLines.geometry.getAttribute('position'))")
                                    .asInt())
                    .isEqualTo(2 * 3 * 2 * 32);
            browser.picture(PICTURES.resolve("perceived.png"));
            browser.ask("document.querySelector('#show-sensors').click()");
            browser.click("[aria-label=\"Highlight what dan perceives\"]");
            browser.await("reve.scene.highlighted.size === 0");

            // The audit record contains what the server sent, and texts of clients are no markup.
            dan.act("dan", "no <img src=x onerror=alert(1)>", Map.of());
            browser.click("#audit-panel summary");
            browser.await(
                    "[...document.querySelectorAll('#audit li')].some(r => r.textContent.includes('<img"
                            + " src=x'))");
            assertThat(browser.ask("document.querySelectorAll('#audit img').length").asInt())
                    .isZero();
            assertThat(browser.text("#audit"))
                    .contains("\"colour\":\"sha256:")
                    .doesNotContain("\"t\":\"perception\"");
            browser.picture(PICTURES.resolve("audit.png"));
            browser.choose("#audit-client", "visitor");
            browser.click("#audit-frequent");
            browser.await(
                    "document.querySelector('#audit').textContent.includes('\"t\":\"perception\"') &&"
                            + " [...document.querySelectorAll('#audit b')].every(b => b.textContent ==="
                            + " 'visitor')");

            // Clients of other roles use the cameras of their own bodies only.
            browser.ask("reve.enter({name: 'ben', role: 'agent'})");
            browser.await("reve.role === 'agent'");
            browser.click(button.formatted("ben"));
            browser.await(middle + "[0] > 100");
            assertThat(browser.ask(distance.formatted("ben")).asDouble())
                    .isCloseTo(4, within(1e-3));
            browser.ask("reve.enter({name: 'eve', role: 'observer'})");
            browser.await(
                    "reve.role === 'observer' && document.querySelector('[data-client=visitor]"
                            + " [aria-label^=Camera]')");
            assertThat(
                            browser.ask(
                                            "document.querySelectorAll('.picture, [data-client=dan]"
                                                    + " [aria-label^=Camera]').length")
                                    .asInt())
                    .isZero();
            assertThat(dan.look("eye").width()).isEqualTo(64);
            assertThat(browser.ask("document.querySelector('#audit-panel').hidden").booleanValue())
                    .isTrue();
            assertThat(browser.errors).isEmpty();
        }
    }

    /** Two balls fall 1 m onto the floor, and bounce. */
    private static final String CHIMES =
            """
            reve: 1
            name: chimes
            frame: {rate: 60, steps: 1}
            laws: [gravity_field, {name: rigid_contact, parameters: {restitution: 0.9}}]
            constants: {gravity: [0, -9.81, 0]}
            items:
              - {name: floor, physical: {shape: box, size: [10, 0.2, 10], location: [0, -0.1, 0]}}
              - {name: light, physical: {shape: sphere, radius: 0.2, location: [-1, 1.2, 0]}, physics: {mass: 1 kg, reactionForce: [0, 0, 0]}}
              - {name: heavy, physical: {shape: sphere, radius: 0.2, location: [1, 1.2, 0]}, physics: {mass: 16 kg}}
            """;

    @Test
    void contactsSoundByTheirForceAfterTheSoundIsSwitchedOn() throws Exception {
        Path world = Files.writeString(folder.resolve("chimes.yaml"), CHIMES);
        browser.size(800, 500); // drawn by the processor
        try (Server server =
                Server.start(
                        folder, "serve", world.toString(), "--port", "0", "--web", "0", "--json")) {
            String page = open(server);
            browser.await(OPEN);
            assertThat(browser.ask("reve.sound.context === null").booleanValue()).isTrue();
            browser.ask("document.querySelector('#sound').focus()");
            browser.press(" ", "Space", 32);
            browser.await(
                    "document.querySelector('#sound').getAttribute('aria-pressed') === 'true'");
            browser.await("reve.sound.context.state === 'running'");
            browser.ask(
                    "(() => { window.ear = new AnalyserNode(reve.sound.context, {fftSize: 32768});"
                            + " reve.sound.output.connect(ear); })()");
            String loudest =
                    "(d => { ear.getFloatTimeDomainData(d); return Math.max(...d); })(new"
                            + " Float32Array(ear.fftSize))";

            // The impulse of the first impact is (1 + e) m v, with v² = 2 g h, and its mean force
            // in
            // a step is this impulse divided by the step.
            browser.ask(
                    "reve.connection.ask('pause').then(() => reve.connection.ask('rewind')).then(() =>"
                            + " { reve.sound.played.length = 0; return"
                            + " reve.connection.ask('run').then(() => true); })");
            String tones = "reve.sound.played.filter(tone => tone.force)";
            browser.await(tones + ".length >= 2");
            JsonNode heavy = browser.ask(tones + "[0]");
            JsonNode light = browser.ask(tones + "[1]");
            assertThat(heavy.get("name").asString()).isEqualTo("heavy");
            assertThat(light.get("name").asString()).isEqualTo("light");
            double newtons = 1.9 * Math.sqrt(2 * 9.81 * 1) * 60;
            // The page receives the newest impact since its last frame. On a busy machine, this may
            // be a later impact. Each impact has 0.9 times the impulse of the impact before it.
            double force = light.get("force").asDouble();
            long impact = Math.round(Math.log(force / newtons) / Math.log(0.9));
            assertThat(impact).isBetween(0L, 4L);
            assertThat(force).isCloseTo(newtons * Math.pow(0.9, impact), withinPercentage(4));
            assertThat(heavy.get("force").asDouble() / light.get("force").asDouble())
                    .isCloseTo(16, withinPercentage(1));
            assertThat(heavy.get("gain").asDouble() / light.get("gain").asDouble())
                    .isCloseTo(4, withinPercentage(1));
            browser.await(loudest + " > 0.05");

            browser.ask(
                    "reve.connection.ask('load-law', {library: 'calm.law', text: 'law calm\\n  each"
                            + " body: force += 0 N (1, 0, 0)\\n'}).then(() => true)");
            browser.await("reve.sound.played.some(tone => tone.name === 'law-loaded')");
            browser.picture(PICTURES.resolve("sound.png"));
            browser.ask("document.activeElement.blur()");
            browser.press("m", "KeyM", 77);
            browser.await("reve.sound.context.state === 'suspended'");
            assertThat(
                            browser.ask(
                                            "document.querySelector('#sound').getAttribute('aria-pressed')")
                                    .asString())
                    .isEqualTo("false");
            requestsStayAt(page);
            assertThat(browser.errors).isEmpty();
        }
    }

    /** Asserts that the page has requested nothing from another server. */
    private void requestsStayAt(String page) {
        String origin = page.substring(0, page.length() - 1);
        assertThat(browser.requests)
                .filteredOn(
                        address -> !address.startsWith("data:") && !address.startsWith("about:"))
                .allMatch(
                        address ->
                                address.startsWith(origin)
                                        || address.startsWith(origin.replace("http", "ws")));
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

    /** A spring with a width is a cylinder, one without a width is a line. */
    @Test
    void springsAndSurfacesAreShownInTheirLook() throws Exception {
        Path world =
                Files.writeString(
                        folder.resolve("looks.yaml"),
                        """
                        reve: 1
                        name: looks
                        items:
                          - {name: a, physical: {shape: sphere, radius: 0.2, location: [-1, 1, 0]}, physics: {mass: 1}}
                          - {name: b, physical: {shape: sphere, radius: 0.2, location: [1, 1, 0]}, physics: {mass: 1}}
                          - {name: c, physical: {shape: sphere, radius: 0.2, location: [0, 3, 0]}, physics: {mass: 1}}
                          - {name: rod, kind: spring, physical: {colour: "#ff0000", width: 0.1}, physics: {end1: a, end2: b}}
                          - {name: line, kind: spring, physical: {colour: "#0000ff"}, physics: {end1: b, end2: c}}
                          - {name: hidden, kind: spring, physical: {colour: "#00ff0000"}, physics: {end1: a, end2: c}}
                          - {name: cloth, kind: surface, physical: {colour: "#00ff00"}, physics: {vertices: [a, b, c]}}
                        """);
        try (Server server =
                Server.start(
                        folder, "serve", world.toString(), "--port", "0", "--web", "0", "--json")) {
            browser.size(640, 400);
            open(server);
            browser.await(OPEN);
            browser.await(
                    "reve.scene.rodMesh.count === 1 && reve.scene.springs.length === 1"
                            + " && reve.scene.triangles.length === 1");
            browser.await(
                    "[1, 0, 0].every((part, i) => reve.scene.rodMesh.instanceColor.array[i] === part)"
                            + " && [[0, 0], [1, 0.1], [4, 2], [12, 0], [13, 1], [14, 0]].every("
                            + "([i, size]) => Math.abs(Math.abs("
                            + "reve.scene.rodMesh.instanceMatrix.array[i]) - size) < 1e-5)");
            browser.await(
                    "[0, 0, 1, 0, 0, 1].every((part, i) =>"
                            + " reve.scene.lines.geometry.getAttribute('color').array[i] === part)");
            browser.await(
                    "[0, 1, 0].every((part, i) =>"
                            + " reve.scene.surfaces.geometry.getAttribute('color').array[i] === part)");
            browser.picture(PICTURES.resolve("looks.png"));
        }
    }

    /** An ellipsoid is a stretched sphere, and a terrain from an image is a mesh. */
    @Test
    void ellipsoidsAndTerrainsAreShownInTheirSize() throws Exception {
        var hills = new BufferedImage(5, 4, BufferedImage.TYPE_USHORT_GRAY);
        hills.getRaster().setSample(2, 2, 0, 65_535);
        ImageIO.write(hills, "png", folder.resolve("hills.png").toFile());
        Path world =
                Files.writeString(
                        folder.resolve("shapes.yaml"),
                        """
                        reve: 1
                        name: shapes
                        items:
                          - {name: egg, physical: {shape: ellipsoid, size: [3, 0.5, 1], location: [0, 3, 0]}}
                          - {name: hills, physical: {shape: terrain, size: [8, 6], file: hills.png, heightRange: [0, 2]}}
                        """);
        try (Server server =
                Server.start(
                        folder, "serve", world.toString(), "--port", "0", "--web", "0", "--json")) {
            browser.size(640, 400);
            open(server);
            browser.await(OPEN);
            browser.await("reve.scene.groups.size === 2");
            browser.await(
                    "[...reve.scene.groups.values()].some(g => g.shape === 7"
                            + " && g.mesh.geometry.type === 'SphereGeometry'"
                            + " && [3, 0.5, 1].every((side, i) =>"
                            + " Math.abs(g.mesh.instanceMatrix.array[5 * i] - side) < 1e-5))");
            browser.await(
                    "[...reve.scene.groups.values()].some(g => {"
                            + " if (g.shape !== 4) return false;"
                            + " g.mesh.geometry.computeBoundingBox();"
                            + " const { min, max } = g.mesh.geometry.boundingBox;"
                            + " return max.x - min.x === 8 && max.y === 2 && max.z - min.z === 6; })");
            browser.picture(PICTURES.resolve("shapes.png"));
            assertThat(browser.errors).isEmpty();
        }
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
