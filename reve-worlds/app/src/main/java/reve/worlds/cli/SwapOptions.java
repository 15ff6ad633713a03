// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;

import reve.core.frame.LawSwap;
import reve.core.text.Rounded;
import reve.worlds.server.SwapPlan;

import java.util.Optional;

/** The options that state how new versions of loaded laws take over. */
final class SwapOptions {
    private static final double MOST_SECONDS = 3600;

    @Option(
            names = "--swap",
            paramLabel = "HOW",
            description =
                    "How a new version of a loaded law, or its new parameters, take over. shadow:"
                            + " after they have acted in a copy of the world; at-once: in the next frame (default: native code"
                            + " and Python in the shadow, texts and parameters at once).")
    private Optional<String> swap = Optional.empty();

    @Option(
            names = "--shadow-seconds",
            paramLabel = "S",
            description =
                    "World time that a new version must act in the shadow [s] (default: "
                            + SwapPlan.DEFAULT_SECONDS
                            + ").")
    private Optional<Double> seconds = Optional.empty();

    @Option(
            names = "--shadow-energy",
            paramLabel = "N",
            description =
                    "Largest energy that a new version may give the bodies in the shadow, as a"
                            + " multiple of their energy (default: "
                            + SwapPlan.DEFAULT_ENERGY_LIMIT
                            + ").")
    private Optional<Double> energy = Optional.empty();

    /**
     * Returns the plan.
     *
     * @throws ParameterException if an option has an invalid value
     */
    SwapPlan plan(CommandSpec spec) {
        Optional<LawSwap> how =
                swap.map(
                        text ->
                                LawSwap.find(text)
                                        .orElseThrow(
                                                () ->
                                                        new ParameterException(
                                                                spec.commandLine(),
                                                                "--swap is '"
                                                                        + text
                                                                        + "', expected shadow or"
                                                                        + " at-once")));
        double most = seconds.orElse(SwapPlan.DEFAULT_SECONDS);
        if (!(most > 0 && most <= MOST_SECONDS)) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--shadow-seconds is "
                            + Rounded.of(most)
                            + ", expected more than 0 and at most "
                            + Rounded.of(MOST_SECONDS)
                            + " s");
        }
        double limit = energy.orElse(SwapPlan.DEFAULT_ENERGY_LIMIT);
        if (!(limit > 0)) {
            throw new ParameterException(
                    spec.commandLine(),
                    "--shadow-energy is " + Rounded.of(limit) + ", expected a number above 0");
        }
        return new SwapPlan(how, most, limit);
    }
}
