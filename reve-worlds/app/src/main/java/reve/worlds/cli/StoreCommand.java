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
import reve.worlds.journal.PostgresStore;
import reve.worlds.journal.PostgresUrl;
import reve.worlds.journal.StoreAddress;
import reve.worlds.server.StoreCheck;
import reve.worlds.server.StoreLaws;

import java.io.IOException;
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
        @Parameters(
                paramLabel = "STORE",
                description = "Store file or URL of a database, as in serve --store.")
        private StoreArgument store;

        @Option(
                names = "--world",
                paramLabel = "NAME",
                description =
                        "World of the database (default: the only one). Only with the URL of a"
                                + " database.")
        private Optional<String> world = Optional.empty();

        @Mixin private LawOptions laws = new LawOptions();

        @Mixin private PluginOptions plugins = new PluginOptions();

        @Option(names = "--json", description = "Print the result as one JSON document.")
        private boolean json;

        private StoreAddress address(CommandSpec spec) throws IOException {
            return store.address(spec, world);
        }

        /** Returns the file of a store that can be repaired. */
        private Path file(CommandSpec spec) throws IOException {
            StoreAddress address = address(spec);
            if (address instanceof StoreAddress.InFile named) {
                return named.file();
            }
            throw new ParameterException(
                    spec.commandLine(),
                    "store repair takes a store file, found the database of "
                            + address
                            + "; restore a database from a backup (pg_dump, pg_basebackup)");
        }
    }

    @Override
    public void run() {
        throw new ParameterException(
                spec.commandLine(), "expected one of check, laws, worlds, repair");
    }

    @Command(
            name = "check",
            description =
                    "Reports whether a store is complete, and from which frame a world would"
                            + " resume. Changes nothing.")
    int check(@Mixin StoreOptions options) throws Exception {
        options.plugins.use();
        StoreAddress address = options.address(spec);
        StoreCheck found = StoreCheck.of(address, folder(address), options.laws.path(spec));
        if (options.json) {
            Json.print(spec, found.fields());
        } else {
            print(found);
        }
        return found.isWhole() ? ExitCode.OK : ExitCode.FAILURE;
    }

    @Command(
            name = "worlds",
            description =
                    "Lists the worlds of a database that several servers share, their owners, and"
                            + " where agents reach them. Changes nothing.")
    int worlds(
            @Parameters(paramLabel = "URL", description = "postgresql://USER@HOST:PORT/DATABASE")
                    StoreArgument store,
            @Option(names = "--json", description = "Print the result as one JSON document.")
                    boolean json)
            throws Exception {
        PostgresUrl url =
                store.url()
                        .orElseThrow(
                                () ->
                                        new ParameterException(
                                                spec.commandLine(),
                                                "store worlds takes postgresql://USER@HOST:PORT/"
                                                        + "DATABASE; found the file "
                                                        + store.given()
                                                        + ", which has one world"));
        List<PostgresStore.World> found = PostgresStore.worlds(url);
        if (json) {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("store", url.toString());
            fields.put("worlds", found.stream().map(StoreCommand::fields).toList());
            Json.print(spec, fields);
            return ExitCode.OK;
        }
        PrintWriter out = spec.commandLine().getOut();
        for (PostgresStore.World each : found) {
            out.println(
                    Visible.line(each.name())
                            + ": frame "
                            + each.frame()
                            + ", epoch "
                            + each.epoch()
                            + (each.isOwned()
                                    ? ", run by " + Visible.line(each.owner())
                                    : ", run by no server")
                            + (each.agents().isEmpty()
                                    ? ""
                                    : ", agents at " + Visible.line(each.agents())));
        }
        if (found.isEmpty()) {
            out.println(url + ": no world");
        }
        out.flush();
        return ExitCode.OK;
    }

    private static Map<String, Object> fields(PostgresStore.World world) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("world", world.name());
        fields.put("frame", world.frame());
        fields.put("epoch", world.epoch());
        fields.put("owner", world.owner());
        fields.put("running", world.isOwned());
        fields.put("agents", world.agents());
        return fields;
    }

    /** Unpacks the files of a world in a database; empty for other stores. */
    private static Optional<Path> folder(StoreAddress address) throws IOException {
        if (address instanceof StoreAddress.InDatabase shared) {
            Optional<byte[]> pack = PostgresStore.pack(shared.url(), shared.world());
            if (pack.isPresent()) {
                return Optional.of(WorldArgument.unpacked(shared.world(), pack.get()).folder());
            }
        }
        return Optional.empty();
    }

    @Command(
            name = "repair",
            description =
                    "Replaces a damaged store by a complete one with the recoverable "
                            + "frames, and keeps the damaged files in FILE.damaged-1.")
    int repair(@Mixin StoreOptions options) throws Exception {
        options.plugins.use();
        Map.Entry<StoreCheck, Optional<Path>> done =
                StoreCheck.repair(options.file(spec), options.laws.path(spec));
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
        options.plugins.use();
        StoreLaws found = StoreLaws.of(options.address(spec), options.laws.path(spec));
        if (options.json) {
            Json.print(spec, found.fields());
        } else {
            print(found, options.store.given());
        }
        return found.isWhole() ? ExitCode.OK : ExitCode.FAILURE;
    }

    private void print(StoreLaws found, String store) {
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
                            + Shortened.hash(law.library().sha256())
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
                            + Shortened.hash(law.sha256())
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
                            + store
                            + " --without-law NAME");
        }
        out.flush();
    }

    private static String parameters(LawLibrary library) {
        return library.parameters().entrySet().stream()
                .map(each -> Visible.line(each.getKey()) + " = " + Shortened.of(each.getValue()))
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
