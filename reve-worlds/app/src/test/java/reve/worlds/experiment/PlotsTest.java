// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.knowm.xchart.XYChart;

import reve.core.file.Experiment;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** The axes of plots, and the numbers on them. */
class PlotsTest {
    @TempDir private Path folder;

    private Experiment experiment(String measures) throws Exception {
        Files.writeString(
                folder.resolve("world.yaml"),
                "{reve: 1, name: w, items: [{name: ball, physics: {mass: 1 kg}}]}");
        return Experiment.load(
                Files.writeString(
                        folder.resolve("e.yaml"),
                        """
                        experiment: 1
                        name: e
                        world: world.yaml
                        seconds: 1
                        sweep: {mass: [500 g, 2 kg], c: [1 kg/s], k: [3]}
                        every: 30
                        measures:
                        """
                                + measures));
    }

    /** Returns results in which each value of a run is {@code value} times its number. */
    private static List<RunResult> results(Experiment experiment, double value) {
        List<RunResult> results = new ArrayList<>();
        for (int i = 0; i < experiment.runs(); i++) {
            Optional<Object> taken = Optional.of(value * (i + 1));
            results.add(
                    new RunResult(
                            experiment.point(i),
                            RunResult.State.OK,
                            "",
                            60,
                            "",
                            List.of(
                                    new Sample(0, 0, List.of(taken)),
                                    new Sample(60, 1, List.of(taken))),
                            List.of(taken),
                            List.of(Optional.of(value)),
                            List.of(),
                            Map.of()));
        }
        return results;
    }

    @Test
    void axesHaveTheUnitsOfTheirNumbers() throws Exception {
        Experiment experiment = experiment("  speed: {of: ball, is: norm(physics.velocity)}\n");
        Map<String, XYChart> charts = Plots.charts(experiment, results(experiment, 10));
        assertThat(charts).containsOnlyKeys("speed-over-mass.png", "speed-over-time.png");
        XYChart overMass = charts.get("speed-over-mass.png");
        assertThat(overMass.getXAxisTitle()).isEqualTo("mass [kg]");
        assertThat(overMass.getYAxisTitle()).isEqualTo("speed [m/s]");
        assertThat(overMass.getSeriesMap().get("c = 1 kg/s, k = 3").getXData())
                .containsExactly(0.5, 2);
        assertThat(overMass.getSeriesMap().get("c = 1 kg/s, k = 3").getYData())
                .containsExactly(10, 20);
        assertThat(charts.get("speed-over-time.png").getYAxisTitle()).isEqualTo("speed [m/s]");
    }

    @Test
    void aUnitOfTheFileConvertsAllNumbersOfTheMeasure() throws Exception {
        Experiment experiment =
                experiment(
                        "  speed: {of: ball, is: norm(physics.velocity), unit: km/h, expected: 1}\n");
        Map<String, XYChart> charts = Plots.charts(experiment, results(experiment, 10));
        XYChart overMass = charts.get("speed-over-mass.png");
        assertThat(overMass.getYAxisTitle()).isEqualTo("speed [km/h]");
        assertThat(overMass.getSeriesMap().get("c = 1 kg/s, k = 3").getYData())
                .containsExactly(new double[] {36, 72}, within(1e-12));
        assertThat(overMass.getSeriesMap().get("c = 1 kg/s, k = 3, expected").getYData())
                .containsExactly(new double[] {36, 36}, within(1e-12));
        assertThat(
                        charts.get("speed-over-time.png")
                                .getSeriesMap()
                                .values()
                                .iterator()
                                .next()
                                .getYData())
                .containsExactly(new double[] {36, 36}, within(1e-12));
    }

    @Test
    void aPeriodIsInSecondsAndAnUnknownUnitIsNotShown() throws Exception {
        Experiment swing =
                experiment("  swing: {of: ball, is: \"physics.velocity[0]\", take: period}\n");
        Map<String, XYChart> charts = Plots.charts(swing, results(swing, 1));
        assertThat(charts.get("swing-over-mass.png").getYAxisTitle()).isEqualTo("swing [s]");
        assertThat(charts.get("swing-over-time.png").getYAxisTitle()).isEqualTo("swing [m/s]");
        Experiment weight = experiment("  weight: {of: ball, is: 9.81 * physics.mass}\n");
        assertThat(
                        Plots.charts(weight, results(weight, 1))
                                .get("weight-over-mass.png")
                                .getYAxisTitle())
                .isEqualTo("weight");
    }
}
