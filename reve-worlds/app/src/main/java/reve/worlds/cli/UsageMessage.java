// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine;
import picocli.CommandLine.Model.OptionSpec;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.UnmatchedArgumentException;

import reve.core.text.Suggestion;

import java.util.Arrays;
import java.util.Collection;
import java.util.List;
import java.util.TreeSet;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/** The message about a wrong command line. */
final class UsageMessage {
    /** A line of a help's footer that describes a command of the launcher script. */
    private static final Pattern OF_LAUNCHER = Pattern.compile(" {2}([a-z][a-z-]*) {2,}\\S.*");

    private UsageMessage() {}

    /** Returns the message, which suggests the command or the option that is probably meant. */
    static String of(ParameterException wrong) {
        CommandLine line = wrong.getCommandLine();
        if (wrong instanceof UnmatchedArgumentException unmatched) {
            String first = unmatched.getUnmatched().getFirst();
            return first.startsWith("-")
                    ? unknownOption(line, first)
                    : line.getSubcommands().isEmpty()
                            ? "'"
                                    + first
                                    + "' is one argument too many for "
                                    + line.getCommandSpec().qualifiedName()
                            : unknownCommand(line, first);
        }
        // The command help reports an unknown name by the value of its exception.
        return wrong.getArgSpec() == null && wrong.getValue() != null
                ? unknownCommand(line, wrong.getValue())
                : String.valueOf(wrong.getMessage());
    }

    private static String unknownOption(CommandLine line, String given) {
        String name = given.replaceFirst("=.*", "");
        List<String> known =
                line.getCommandSpec().options().stream()
                        .map(OptionSpec::names)
                        .flatMap(Arrays::stream)
                        .toList();
        return line.getCommandSpec().qualifiedName()
                + " has no option '"
                + name
                + "'"
                + Suggestion.of(name, known);
    }

    private static String unknownCommand(CommandLine line, String given) {
        Collection<String> known = new TreeSet<>(line.getSubcommands().keySet());
        for (String text : line.getCommandSpec().usageMessage().footer()) {
            Matcher described = OF_LAUNCHER.matcher(text);
            if (described.matches()) {
                known.add(described.group(1));
            }
        }
        String near = Suggestion.of(given, known);
        return line.getCommandSpec().qualifiedName()
                + " has no command '"
                + given
                + "'"
                + (near.isEmpty() ? ", expected one of " + String.join(", ", known) : near);
    }
}
