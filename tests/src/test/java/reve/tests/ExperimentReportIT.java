// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;

/**
 * The report of an experiment in a headless Chromium, opened as a file. Pictures of the test are in
 * build/reports/page.
 */
@Tag("slow")
class ExperimentReportIT {
    private static final Path PICTURES = Project.ROOT.resolve("build/reports/page");
    private static final String MARKUP = "<img src=x onerror=\"document.title='hit'\">";

    @TempDir private Path folder;

    private Outcome run(String experiment, String... more) throws Exception {
        Document page = Document.read(Project.ROOT.resolve("docs/experiments.md"));
        Files.writeString(folder.resolve("syrup.yaml"), page.titled("syrup.yaml").text());
        Path file = Files.writeString(folder.resolve("e.yaml"), experiment);
        List<String> command =
                new ArrayList<>(
                        List.of(
                                "experiment",
                                file.toString(),
                                "--out",
                                folder.resolve("out").toString(),
                                "--engine",
                                "in-process"));
        command.addAll(List.of(more));
        return Reve.run(command.toArray(String[]::new));
    }

    private static String sinking() throws Exception {
        return Document.read(Project.ROOT.resolve("docs/experiments.md"))
                .titled("sinking.yaml")
                .text();
    }

    @Test
    void theReportShowsRunsAndPlotsAndRequestsNothing() throws Exception {
        Outcome outcome =
                run(sinking() + "doc: A ball sinks in syrup until its drag balances its weight.\n");
        assertThat(outcome.code()).as(outcome.err()).isZero();
        assertThat(outcome.out()).contains("result.json, report.html");
        Path report = folder.resolve("out/report.html");
        try (Browser browser =
                new Browser(Files.createDirectory(folder.resolve("profile")), 1280, 900)) {
            browser.open(report.toUri().toString());
            browser.await("document.querySelectorAll('#table tbody tr').length === 8");
            assertThat(browser.text("h1")).isEqualTo("sinking");
            assertThat(browser.text(".doc")).startsWith("A ball sinks in syrup");
            assertThat(browser.text(".counts")).isEqualTo("8 runs8 ok");
            assertThat(browser.text("thead"))
                    .isEqualTo(
                            "runc [kg/s]mass [kg]seedspeed [m/s]expectederrordepth [m]statestate"
                                    + " hash");
            assertThat(browser.ask("document.querySelectorAll('svg').length").asInt())
                    .isEqualTo(4); // speed and depth, over mass and over time
            // Eight measured points over mass are drawn as marks, and two expected lines.
            assertThat(browser.ask(count("figure:first-child circle")).asInt()).isEqualTo(8);
            assertThat(browser.ask(count("figure:first-child .dash")).asInt()).isEqualTo(2);
            assertThat(browser.text("figure:first-child svg desc"))
                    .contains("c = 1 kg/s: 4 points, from (0.05, 0.4905) to (0.4, 3.9).");
            // Every picture has a name for screen readers, and no text lies outside of its picture.
            assertThat(
                            browser.ask(
                                            "[...document.querySelectorAll('svg')].every(s =>"
                                                    + " s.getAttribute('aria-labelledby').split(' ')"
                                                    + ".every(id => document.getElementById(id)"
                                                    + ".textContent.length > 9))")
                                    .asBoolean())
                    .isTrue();
            assertThat(
                            browser.ask(
                                            "[...document.querySelectorAll('svg')].every(s => {"
                                                    + " const o = s.getBoundingClientRect(); return"
                                                    + " [...s.querySelectorAll('text, circle')].every(e"
                                                    + " => { const b = e.getBoundingClientRect(); return"
                                                    + " b.left > o.left - 1 && b.right < o.right + 1 &&"
                                                    + " b.top > o.top - 1 && b.bottom < o.bottom + 1;"
                                                    + " }); })")
                                    .asBoolean())
                    .isTrue();
            browser.picture(PICTURES.resolve("report.png"));

            browser.click("thead th:nth-child(5) button");
            browser.await(
                    "document.querySelector('thead th:nth-child(5)').getAttribute('aria-sort') ==="
                            + " 'ascending'");
            // The cells are rounded. Their titles have all digits.
            List<Double> speeds = speeds(browser);
            assertThat(speeds).hasSize(8).isSorted().first().isNotEqualTo(speeds.getLast());
            browser.click("thead th:nth-child(5) button");
            assertThat(speeds(browser)).isEqualTo(speeds.reversed());

            String before =
                    browser.ask("getComputedStyle(document.body).backgroundColor").asString();
            browser.ask("scrollTo(0, 0)");
            browser.click("#theme");
            String after =
                    browser.ask("getComputedStyle(document.body).backgroundColor").asString();
            assertThat(after).isNotEqualTo(before);
            browser.picture(PICTURES.resolve("report-other-theme.png"));
            browser.size(390, 800);
            assertThat(browser.ask("document.documentElement.scrollWidth").asInt())
                    .isLessThanOrEqualTo(390);
            browser.picture(PICTURES.resolve("report-narrow.png"));
            assertThat(browser.requests).containsOnly(report.toUri().toString());
            assertThat(browser.errors).isEmpty();
        }
    }

    private static String count(String selector) {
        return "document.querySelectorAll('" + selector + "').length";
    }

    private static List<Double> speeds(Browser browser) throws Exception {
        List<Double> speeds = new ArrayList<>();
        browser.ask(
                        "[...document.querySelectorAll('#table tbody tr')].map(row =>"
                                + " Number(row.cells[4].title))")
                .forEach(speed -> speeds.add(speed.asDouble()));
        return speeds;
    }

    @Test
    void seedsCasesFailuresAndTextsOfTheFileAreShownAsTheyAre() throws Exception {
        Outcome outcome =
                run(
                        """
                        experiment: 1
                        name: hostile
                        doc: '%s'
                        world: syrup.yaml
                        seconds: 0.2
                        seeds: 3
                        sweep: {m: [1, 2]}
                        cases:
                          euler: {laws: [gravity_field, drag, newton_motion]}
                          verlet: {laws: [gravity_field, drag, velocity_verlet]}
                        set:
                          items.ball.physics.velocity: "{3 * ball(1)}"
                          items.ball.physics.mass: "{m}"
                        measures:
                          energy: {energy: kinetic}
                          missing: {of: ball, is: semantic.none}
                        """
                                .formatted(MARKUP.replace("'", "''")));
        assertThat(outcome.code()).as(outcome.err()).isZero();
        Path report = folder.resolve("out/report.html");
        try (Browser browser =
                new Browser(Files.createDirectory(folder.resolve("profile")), 1280, 900)) {
            browser.open(report.toUri().toString());
            browser.await("document.querySelectorAll('#table tbody tr').length === 12");
            assertThat(browser.text(".doc")).isEqualTo(MARKUP);
            assertThat(browser.text("#table tbody tr td")).isEqualTo("euler");
            assertThat(browser.ask(count("img")).asInt()).isZero();
            assertThat(browser.ask("document.title").asString())
                    .isEqualTo("hostile, results of an experiment");
            // The only plot does not grow with the page.
            assertThat(
                            browser.ask(
                                            "document.querySelector('svg').getBoundingClientRect().width")
                                    .asDouble())
                    .isLessThan(700);
            // Three seeds give a mean with a bar.
            assertThat(browser.ask(count("svg .bar")).asInt()).isEqualTo(4);
            assertThat(browser.text("section")).contains("Each point is the mean over the seeds");
            assertThat(browser.text("#notes")).isEqualTo("Messages");
            assertThat(browser.ask(count("td.none")).asInt()).isEqualTo(12);
            assertThat(browser.errors).isEmpty();
            browser.picture(PICTURES.resolve("report-seeds.png"));
        }
    }

    @Test
    void equalResultsGiveEqualReports() throws Exception {
        String two =
                sinking().replace("count: 4", "count: 2").replace("seconds: 2", "seconds: 0.5");
        Outcome outcome = run(two.replaceAll(" +(expected|tolerance):.*\n", ""), "--jobs", "1");
        assertThat(outcome.code()).as(outcome.err()).isZero();
        String first = Files.readString(folder.resolve("out/report.html"));
        assertThat(first).doesNotContain(folder.toString());
        outcome = run(two.replaceAll(" +(expected|tolerance):.*\n", ""), "--replace");
        assertThat(outcome.code()).as(outcome.err()).isZero();
        assertThat(Files.readString(folder.resolve("out/report.html"))).isEqualTo(first);
    }

    @Test
    void eachRunIsPrintedAsALineAsSoonAsItHasEnded() throws Exception {
        Outcome outcome = run(sinking(), "--json-lines");
        assertThat(outcome.code()).as(outcome.err()).isZero();
        List<JsonNode> lines =
                outcome.out().lines().map(line -> new JsonMapper().readTree(line)).toList();
        assertThat(lines).hasSize(9);
        for (int i = 0; i < 8; i++) {
            assertThat(lines.get(i).path("event").asString()).isEqualTo("run");
            assertThat(lines.get(i).path("ended").asInt()).isEqualTo(i + 1);
            assertThat(lines.get(i).path("runs").asInt()).isEqualTo(8);
        }
        JsonNode result = lines.getLast();
        assertThat(result.path("event").asString()).isEqualTo("result");
        assertThat(result.path("runs").get(0).path("values"))
                .isEqualTo(
                        lines.stream()
                                .filter(line -> line.path("run").asInt() == 1)
                                .findFirst()
                                .orElseThrow()
                                .path("values"));
        Outcome both = run(sinking(), "--json-lines", "--json");
        assertThat(both.code()).isEqualTo(2);
        assertThat(both.err()).contains("leave one of them out");
    }
}
