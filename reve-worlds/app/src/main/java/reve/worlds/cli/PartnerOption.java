// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.ParameterException;

import java.util.Optional;

/** A check of options that depend on another option. */
final class PartnerOption {
    private PartnerOption() {}

    /**
     * Refuses an option without the other option that it needs.
     *
     * @param other name and parameter of the other option
     */
    static void require(
            CommandSpec spec, String option, boolean given, String other, Optional<?> otherValue) {
        if (given && otherValue.isEmpty()) {
            throw new ParameterException(
                    spec.commandLine(), option + " takes " + other + "; found none");
        }
    }

    /** Refuses a number below 1, and an option without the other option that it needs. */
    static void requireCount(
            CommandSpec spec,
            String option,
            Optional<Integer> given,
            String other,
            Optional<?> otherValue) {
        if (given.isPresent() && given.get() < 1) {
            throw new ParameterException(
                    spec.commandLine(), option + " is " + given.get() + ", expected 1 or more");
        }
        require(spec, option, given.isPresent(), other, otherValue);
    }
}
