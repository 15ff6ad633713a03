// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;

/**
 * The command {@code law}. Only {@code law plot} runs in Java. The launcher script passes the other
 * commands to the program {@code vesper}.
 */
@Command(
        name = "law",
        description = "Checks, runs and plots laws as text, and writes them as C++.",
        subcommands = LawPlotCommand.class,
        footer = {
            "  check   Checks a law: names, units, grammar.",
            "  run     Runs a small scene with a law; prints how energy and momentum change.",
            "  to-cpp  Writes a law as a C++ law that gives the same results.",
            "",
            "Each takes the FILE of a law; `law check --help` lists the options of `check`.",
        })
public final class LawCommand {}
