// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.Spec;

import reve.worlds.demo.Demo;
import reve.worlds.demo.DemoReport;

import java.io.PrintWriter;
import java.nio.file.Path;
import java.util.concurrent.Callable;

/**
 * The command {@code demo}: runs a server and agents, adds a law to the running world, and takes
 * pictures.
 */
@Command(
        name = "demo",
        subcommands = DemoClusterCommand.class,
        description =
                "Demonstrates a server with two agents and a law dropped into the running "
                        + "world, and takes pictures.")
public final class DemoCommand implements Callable<Integer> {
    @Spec private CommandSpec spec = CommandSpec.create();

    @Option(
            names = "--out",
            paramLabel = "DIR",
            description =
                    "Folder for pictures and logs (default: build/demo of a checkout, else "
                            + "reve-demo in this folder).")
    private Path out = OptionFolder.ofDemo("demo");

    @Option(names = "--json", description = "Print the result as one JSON document.")
    private boolean json;

    @Override
    public Integer call() throws Exception {
        Path root = Path.of(System.getProperty("reve.root", ".")).toAbsolutePath().normalize();
        OptionFolder.make(spec, "--out", out);
        DemoReport report = new Demo(root, out, System.err).run();
        if (json) {
            Json.print(spec, report.fields());
        } else {
            PrintWriter printer = spec.commandLine().getOut();
            report.print(printer);
            printer.flush();
        }
        return ExitCode.OK;
    }
}
