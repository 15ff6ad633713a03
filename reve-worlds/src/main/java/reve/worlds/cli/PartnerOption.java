// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.ParameterException;

import java.util.Optional;

/** An option that says how to do what another option asks for. */
final class PartnerOption {
    private PartnerOption() {}

    /**
     * Refuses the option where the other one is missing.
     *
     * @param other name and parameter of the option that this one belongs to
     */
    static void require(
            CommandSpec spec, String option, boolean given, String other, Optional<?> otherValue) {
        if (given && otherValue.isEmpty()) {
            throw new ParameterException(
                    spec.commandLine(), option + " takes " + other + "; found none");
        }
    }

    /** The same of a number, which must be 1 or more. */
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
