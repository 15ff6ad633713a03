// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.worlds.journal.RecordingPlan;
import reve.worlds.journal.SqliteStore;
import reve.worlds.journal.StoreAddress;

import java.nio.file.Path;
import java.util.Optional;

/**
 * The data about a world that is written to disk while the world runs.
 *
 * @param folder the folder of the world file
 * @param recording plan for a recording of the run; empty for none
 * @param store place from which the world resumes and in which it is stored; empty for none
 * @param saves folder for world files that are saved while the world runs; belongs to this world
 *     only
 * @param imageSeconds world time between two images in the store [s]
 * @param durability the durability of the store
 */
public record Persistence(
        Path folder,
        Optional<RecordingPlan> recording,
        Optional<StoreAddress> store,
        Optional<Path> saves,
        double imageSeconds,
        SqliteStore.Durability durability) {}
