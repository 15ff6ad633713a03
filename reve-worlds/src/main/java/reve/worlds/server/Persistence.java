// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.worlds.journal.RecordingPlan;
import reve.worlds.journal.SqliteStore;

import java.nio.file.Path;
import java.util.Optional;

/**
 * What is kept of a world while it runs.
 *
 * @param folder of the world file
 * @param recording of the run, if there is to be one
 * @param store file that the world lives in
 * @param saves folder for world files that are saved while the world runs
 * @param imageSeconds an image goes to the store every so much world time [s]
 * @param durability of the store
 */
public record Persistence(
        Path folder,
        Optional<RecordingPlan> recording,
        Optional<Path> store,
        Optional<Path> saves,
        double imageSeconds,
        SqliteStore.Durability durability) {}
