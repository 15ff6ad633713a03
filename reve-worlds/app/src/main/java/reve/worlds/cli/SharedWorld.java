// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Spec;

import reve.worlds.journal.PostgresStore;
import reve.worlds.journal.PostgresUrl;
import reve.worlds.journal.StoreAddress;
import reve.worlds.server.LawPath;
import reve.worlds.server.StoredRun;

import java.io.IOException;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.util.Optional;

/** The option by which a command reads a world of a database that several servers share. */
final class SharedWorld {
    @Spec(Spec.Target.MIXEE)
    private CommandSpec spec = CommandSpec.create();

    @Option(
            names = "--store",
            paramLabel = "URL",
            description =
                    "Read the world of this name from the database"
                            + " postgresql://USER@HOST:PORT/DATABASE, with all frames that the"
                            + " database has. A server may run the world meanwhile.")
    private Optional<StoreArgument> store = Optional.empty();

    /**
     * A world of a database.
     *
     * @param files the files of the world, which the database has, too
     */
    record Found(StoreAddress address, WorldArgument files) {
        /** Opens the frames of the world. */
        StoredRun open(LawPath laws) throws IOException {
            return StoredRun.open(address, Optional.of(files.folder()), laws);
        }
    }

    /**
     * Returns a world of the database; empty without the option.
     *
     * @param name the argument of the command
     * @throws ParameterException if the option names no database
     * @throws NoSuchFileException if the database has no such world
     * @throws IOException if the database is away
     */
    Optional<Found> find(Path name) throws IOException {
        if (store.isEmpty()) {
            return Optional.empty();
        }
        String world = name.toString();
        PostgresUrl url =
                store.get()
                        .url()
                        .orElseThrow(
                                () ->
                                        new ParameterException(
                                                spec.commandLine(),
                                                "--store is "
                                                        + store.get().given()
                                                        + ", expected"
                                                        + " postgresql://USER@HOST:PORT/DATABASE;"
                                                        + " name a store in a file without this"
                                                        + " option"));
        Optional<byte[]> pack = PostgresStore.pack(url, world);
        if (pack.isEmpty()) {
            throw new NoSuchFileException(
                    url + " has no world '" + world + "'" + store.get().others(world));
        }
        return Optional.of(
                new Found(
                        new StoreAddress.InDatabase(url, world, Optional.empty()),
                        WorldArgument.unpacked(world, pack.get())));
    }
}
