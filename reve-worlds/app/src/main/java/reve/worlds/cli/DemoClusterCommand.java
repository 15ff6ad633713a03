// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.Spec;

import reve.worlds.demo.ClusterDemo;
import reve.worlds.demo.ClusterDemoReport;

import java.io.IOException;
import java.io.PrintWriter;
import java.nio.file.Path;
import java.util.Optional;
import java.util.concurrent.Callable;

/** The command {@code demo cluster}: shows that a world outlives the server that runs it. */
@Command(
        name = "cluster",
        description =
                "Demonstrates a cluster: three servers on this machine with a PostgreSQL database of"
                        + " their own, a kill -9 of the one that runs the world, and the same world"
                        + " on another one.")
final class DemoClusterCommand implements Callable<Integer> {
    @Spec private CommandSpec spec = CommandSpec.create();

    @Option(
            names = "--out",
            paramLabel = "DIR",
            description =
                    "Folder for pictures and logs (default: build/demo-cluster of a checkout, "
                            + "else reve-demo-cluster in this folder).")
    private Path out = OptionFolder.ofDemo("demo-cluster");

    @Option(
            names = "--postgres",
            paramLabel = "DIR",
            description =
                    "Folder with the programs of PostgreSQL (default: the newest in PATH or"
                            + " /usr/lib/postgresql).")
    private Optional<Path> postgres = Optional.empty();

    @Option(names = "--json", description = "Print the result as one JSON document.")
    private boolean json;

    @Override
    public Integer call() throws Exception {
        Path root = Path.of(System.getProperty("reve.root", ".")).toAbsolutePath().normalize();
        OptionFolder.make(spec, "--out", out);
        ClusterDemoReport report;
        try {
            report = new ClusterDemo(root, out, postgres, System.err).run();
        } catch (IllegalStateException failed) {
            throw new IOException(failed.getMessage(), failed);
        }
        if (json) {
            Json.print(spec, report.fields());
        } else {
            PrintWriter printer = spec.commandLine().getOut();
            report.print(printer);
            printer.flush();
        }
        return report.isSame() ? ExitCode.OK : ExitCode.FAILURE;
    }
}
