// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.ParameterException;

import reve.core.text.Suggestion;
import reve.worlds.journal.PostgresStore;
import reve.worlds.journal.PostgresUrl;
import reve.worlds.journal.StoreAddress;

import java.io.IOException;
import java.nio.file.Path;
import java.util.List;
import java.util.Optional;

/**
 * The name of a store: a file, or the URL of a database that several servers share.
 *
 * @param given the text that the user gave
 * @param url empty for a file
 * @param file empty for a database
 */
record StoreArgument(String given, Optional<PostgresUrl> url, Optional<Path> file) {
    /**
     * Returns the place of one world.
     *
     * @param world the name of the world in a database; if empty, the database must have one world
     */
    StoreAddress address(CommandSpec spec, Optional<String> world) throws IOException {
        if (url.isEmpty()) {
            if (world.isPresent()) {
                throw new ParameterException(
                        spec.commandLine(),
                        "--world is for a store in a database; a store in a file has one world");
            }
            return new StoreAddress.InFile(file.orElseThrow());
        }
        return new StoreAddress.InDatabase(
                url.get(), world.isPresent() ? world.get() : onlyWorld(spec), Optional.empty());
    }

    private String onlyWorld(CommandSpec spec) throws IOException {
        List<String> names = worlds();
        if (names.size() == 1) {
            return names.getFirst();
        }
        throw new ParameterException(
                spec.commandLine(),
                url.orElseThrow()
                        + (names.isEmpty()
                                ? " has no world"
                                : " has the worlds "
                                        + String.join(", ", names)
                                        + "; name one with --world NAME"));
    }

    /** Returns the worlds of the database, as the end of a message about a missing world. */
    String others(String missing) throws IOException {
        List<String> names = worlds();
        return names.isEmpty()
                ? ", it has none"
                : ", expected one of " + String.join(", ", names) + Suggestion.of(missing, names);
    }

    /** Returns the names of the worlds of the database. */
    List<String> worlds() throws IOException {
        return PostgresStore.worlds(url.orElseThrow()).stream()
                .map(PostgresStore.World::name)
                .toList();
    }
}
