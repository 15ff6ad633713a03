// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.agent.port.CarriedSession;
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
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalLong;
import java.util.Set;
import java.util.function.Consumer;

/**
 * A world at the last frame of its store, or a new world if the store is empty. The caller closes
 * the simulation and the store.
 *
 * @param stateHash the hash of the world's state at that frame, before the agents of the previous
 *     process were removed
 * @param epoch the epoch in which this process writes to a shared store; empty for other stores
 * @param sessions the sessions of the previous server that continue
 */
record StoredWorld(
        Simulation simulation,
        JournalSink store,
        long stateHash,
        OptionalLong epoch,
        List<CarriedSession> sessions) {

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
     * @throws CorruptException if there is no store at the address, or the store belongs to another
     *     world or is incomplete
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
                return kept(begun, taken, begun.physics().stateHash(), List.of());
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
                replay.missingPlugins()
                        .forEach(problem -> problems.accept(address + ": " + problem));
                Simulation resumed = replay.release();
                replay.ruleProblems().forEach(problem -> problems.accept(address + ": " + problem));
                Map<String, Long> members = replay.members();
                List<CarriedSession> continued =
                        taken.sessions().stream()
                                .filter(session -> isWhole(session, members, resumed.world()))
                                .toList();
                StoredWorld world = kept(resumed, taken, resumed.physics().stateHash(), continued);
                Set<String> stay = new HashSet<>();
                continued.forEach(session -> stay.add(session.client()));
                members.forEach(
                        (agent, body) -> {
                            if (!stay.contains(agent)) {
                                leave(resumed, agent, body);
                            }
                        });
                return world;
            }
        }
    }

    /** Returns the folder of the world's files; empty if the store names the folder. */
    private static Optional<Path> folderOf(StoreAddress address, Path folder) {
        return address.isShared() ? Optional.of(folder) : Optional.empty();
    }

    /** Returns whether the client of a session is in the world, with its body if it has one. */
    private static boolean isWhole(CarriedSession session, Map<String, Long> members, World world) {
        Long body = members.get(session.client());
        return session.body().isEmpty()
                ? body == null
                : body != null
                        && body == session.body().getAsLong()
                        && world.find(new ItemId(body)).isPresent();
    }

    /** Returns the ids of the bodies of agents whose sessions continue, by agent. */
    Map<String, Long> members() {
        Map<String, Long> members = new LinkedHashMap<>();
        sessions.forEach(
                session -> session.body().ifPresent(body -> members.put(session.client(), body)));
        return members;
    }

    private static StoredWorld kept(
            Simulation simulation, TakenStore taken, long stateHash, List<CarriedSession> sessions)
            throws IOException {
        try {
            return new StoredWorld(simulation, taken.open(), stateHash, taken.epoch(), sessions);
        } catch (IOException | RuntimeException e) {
            simulation.close();
            throw e;
        }
    }

    /**
     * Replays all frames of a store. Refuses the store if the replay fails, before any of its files
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
