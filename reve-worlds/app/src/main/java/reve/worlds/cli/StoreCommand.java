// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;
import picocli.CommandLine.Spec;

import reve.core.text.Visible;
import reve.pe.adapter.LawLibrary;
import reve.pe.adapter.Quarantined;
import reve.worlds.Product;
import reve.worlds.server.StoreCheck;
import reve.worlds.server.StoreLaws;

import java.io.PrintWriter;
import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.stream.Collectors;

/**
 * The command {@code store}. It checks a store that no server has open, lists the laws of a store,
 * and repairs a damaged store.
 */
@Command(
        name = "store",
        description =
                "Checks a store that no server has open, lists its laws, and repairs a damaged one.")
public final class StoreCommand implements Runnable {
    @Spec private CommandSpec spec = CommandSpec.create();

    /** The options that both subcommands have. */
    static final class StoreOptions {
        @Parameters(paramLabel = "FILE", description = "Store file, as in serve --store.")
        private Path file = Path.of("");

        @Mixin private LawOptions laws = new LawOptions();

        @Option(names = "--json", description = "Print the result as one JSON document.")
        private boolean json;
    }

    @Override
    public void run() {
        throw new ParameterException(spec.commandLine(), "expected one of check, laws, repair");
    }

    @Command(
            name = "check",
            description =
                    "Reports whether a store is complete, and from which frame a world would"
                            + " resume. Changes nothing.")
    int check(@Mixin StoreOptions options) throws Exception {
        StoreCheck found = StoreCheck.of(options.file, options.laws.path(spec));
        if (options.json) {
            Json.print(spec, found.fields());
        } else {
            print(found);
        }
        return found.isWhole() ? ExitCode.OK : ExitCode.FAILURE;
    }

    @Command(
            name = "repair",
            description =
                    "Replaces a damaged store by a complete one with the recoverable "
                            + "frames, and keeps the damaged files in FILE.damaged-1.")
    int repair(@Mixin StoreOptions options) throws Exception {
        Map.Entry<StoreCheck, Optional<Path>> done =
                StoreCheck.repair(options.file, options.laws.path(spec));
        StoreCheck was = done.getKey();
        if (options.json) {
            Map<String, Object> fields = new LinkedHashMap<>(was.fields());
            done.getValue().ifPresent(folder -> fields.put("damaged", folder.toString()));
            Json.print(spec, fields);
            return ExitCode.OK;
        }
        print(was);
        PrintWriter out = spec.commandLine().getOut();
        out.println(
                done.getValue()
                        .map(
                                folder ->
                                        "repaired: continues from frame "
                                                + was.frame()
                                                + "; the files as they were are in "
                                                + folder)
                        .orElse("nothing to repair"));
        out.flush();
        return ExitCode.OK;
    }

    @Command(
            name = "laws",
            description =
                    "Lists the laws of a store by name and content, and those in quarantine. Opens"
                            + " no law, and changes nothing.")
    int laws(@Mixin StoreOptions options) throws Exception {
        StoreLaws found = StoreLaws.of(options.file, options.laws.path(spec));
        if (options.json) {
            Json.print(spec, found.fields());
        } else {
            print(found);
        }
        return found.isWhole() ? ExitCode.OK : ExitCode.FAILURE;
    }

    private void print(StoreLaws found) {
        PrintWriter out = spec.commandLine().getOut();
        found.problems().forEach(problem -> out.println(Visible.line(problem)));
        out.println(
                found.frame() < 0
                        ? found.store() + ": nothing can be recovered"
                        : found.store()
                                + ": laws at frame "
                                + found.frame()
                                + (found.laws().isEmpty()
                                        ? ": none"
                                        : ", in the order of loading"));
        for (StoreLaws.Law law : found.laws()) {
            out.println(
                    "  "
                            + Visible.line(law.library().name())
                            + ": "
                            + law.kind()
                            + ", "
                            + law.library().bytes().length
                            + " bytes, SHA-256 "
                            + law.library().sha256()
                            + (law.library().parameters().isEmpty()
                                    ? ""
                                    : ", " + parameters(law.library())));
        }
        for (Quarantined law : found.quarantined()) {
            out.println(
                    "in quarantine since frame "
                            + law.frame()
                            + ": "
                            + Visible.line(law.library())
                            + ", SHA-256 "
                            + law.sha256()
                            + ": "
                            + law.status()
                            + ": "
                            + Visible.line(law.message()));
        }
        if (!found.laws().isEmpty()) {
            out.println(
                    "to continue without a law: "
                            + Product.command()
                            + " serve WORLD --store "
                            + found.store()
                            + " --without-law NAME");
        }
        out.flush();
    }

    private static String parameters(LawLibrary library) {
        return library.parameters().entrySet().stream()
                .map(each -> Visible.line(each.getKey()) + " = " + each.getValue())
                .collect(Collectors.joining(", "));
    }

    private void print(StoreCheck found) {
        PrintWriter out = spec.commandLine().getOut();
        List<String> problems = found.problems();
        problems.forEach(out::println);
        out.println(found.store() + (found.isWhole() ? ": whole" : ": damaged"));
        if (found.frame() >= 0) {
            out.printf(
                    "comes back to frame %d, state hash %s%n",
                    found.frame(), found.fields().get("stateHash"));
        } else {
            out.println("nothing can be recovered");
        }
        if (found.knownFrame() > found.frame()) {
            out.printf("lost: frames %d to %d%n", found.frame() + 1, found.knownFrame());
        }
        out.flush();
    }
}
