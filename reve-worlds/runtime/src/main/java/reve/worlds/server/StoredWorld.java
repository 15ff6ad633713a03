// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.file.WorldDescription;
import reve.core.frame.Pacing;
import reve.core.image.CorruptException;
import reve.core.world.Departure;
import reve.core.world.Item;
import reve.core.world.ItemId;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.pe.PhysicsException;
import reve.worlds.journal.JournalSink;
import reve.worlds.journal.SqliteStore;
import reve.worlds.journal.StoreAddress;
import reve.worlds.journal.StoreReading;
import reve.worlds.journal.TakenStore;

import java.io.IOException;
import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalLong;
import java.util.function.Consumer;

/**
 * A world at the last frame of its store, or a new world if the store is empty. The caller closes
 * the simulation and the store.
 *
 * @param stateHash the hash of the world's state at that frame, before the agents of the previous
 *     process were removed
 * @param epoch the epoch in which this process writes to a shared store; empty for other stores
 */
record StoredWorld(Simulation simulation, JournalSink store, long stateHash, OptionalLong epoch) {

    /** Returns the loss that the problems of a store have caused, as the end of a message. */
    private static String cost(StoreReading contents) {
        long lost = contents.knownFrame() - contents.frame();
        return lost <= 0
                ? "; nothing is lost"
                : "; the world resumes at frame "
                        + contents.frame()
                        + ", and "
                        + (lost == 1 ? "the frame after it is" : lost + " frames after it are")
                        + " lost";
    }

    /**
     * Opens a store and restores its world.
     *
     * @param folder the folder of the world file
     * @param laws search path of the world's laws, and which of the store's laws may be opened
     * @param problems receives descriptions of damage that loses no data, on any thread
     * @throws IOException if the store cannot be opened or read
     * @throws PhysicsException if a law of the store may not be opened, or does not load
     * @throws CorruptException if it is not a store, belongs to another world, or is incomplete
     */
    static StoredWorld open(
            StoreAddress address,
            SqliteStore.Durability durability,
            WorldDescription description,
            Path folder,
            Pacing pacing,
            LawPath laws,
            Consumer<String> problems)
            throws IOException {
        try (TakenStore taken = address.take(durability, problems)) {
            StoreReading contents = taken.contents();
            contents.requireWhole();
            if (contents.isEmpty()) {
                Simulation begun = new Simulation(description, pacing, laws);
                return kept(begun, taken, begun.physics().stateHash());
            }
            String cost = cost(contents);
            contents.problems().forEach(problem -> problems.accept(problem + cost));
            LawFiles found =
                    new LawFiles(laws, problem -> problems.accept(address + ": " + problem));
            try (Replay replay =
                    new Replay(
                            Optional.of(description),
                            folderOf(address, folder),
                            pacing,
                            laws,
                            found::find)) {
                make(replay, contents);
                Simulation resumed = replay.release();
                StoredWorld world = kept(resumed, taken, resumed.physics().stateHash());
                replay.members().forEach((agent, body) -> leave(resumed, agent, body));
                return world;
            }
        }
    }

    /** Returns the folder of the world's files; empty if the store names the folder. */
    private static Optional<Path> folderOf(StoreAddress address, Path folder) {
        return address.isShared() ? Optional.of(folder) : Optional.empty();
    }

    private static StoredWorld kept(Simulation simulation, TakenStore taken, long stateHash)
            throws IOException {
        try {
            return new StoredWorld(simulation, taken.open(), stateHash, taken.epoch());
        } catch (IOException | RuntimeException e) {
            simulation.close();
            throw e;
        }
    }

    /**
     * Replays all frames of a store. If the replay fails, refuses the store before any of its files
     * is changed.
     */
    private static void make(Replay replay, StoreReading contents) {
        Optional<StoreCheck.End> end = StoreCheck.make(replay, contents);
        if (end.isPresent() && replay.frame() < 0) {
            throw new CorruptException(contents.name() + ": " + end.get().reason());
        }
        end.ifPresent(
                early -> {
                    throw contents.refusal(early.reason(), early.frame());
                });
    }

    /** Removes an agent whose connection ended with the previous process. */
    private static void leave(Simulation resumed, String agent, long body) {
        World world = resumed.world();
        long frame = resumed.loop().frame() + 1;
        Optional<Item> item = world.find(new ItemId(body));
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("agent", agent);
        fields.put("body", item.map(Item::name).orElse(""));
        fields.put("reason", "server-restarted");
        item.filter(own -> !resumed.description().agents().bodies().contains(own.name()))
                .ifPresent(
                        own ->
                                Departure.of(world, own.id())
                                        .raise(world, frame, agent, own.name()));
        world.raise(new WorldEvent(frame, "left", fields));
    }
}
