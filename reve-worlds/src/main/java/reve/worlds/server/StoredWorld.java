package reve.worlds.server;

import java.io.IOException;
import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.function.Consumer;
import reve.core.file.WorldDescription;
import reve.core.frame.Pacing;
import reve.core.store.CorruptException;
import reve.core.world.Item;
import reve.core.world.ItemId;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.pe.PhysicsException;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.SqliteStore;

/**
 * A world as its store has it last, or a new one if the store is empty. The caller closes the
 * simulation and the store.
 *
 * @param stateHash of the world as the store had it, before agents that are gone were taken out
 */
record StoredWorld(Simulation simulation, SqliteStore store, long stateHash) {

    /**
     * @param laws where the world's laws are found, and which of the store's may be opened
     * @param problems told of what is damaged and was passed over
     * @throws IOException if the store cannot be opened or read
     * @throws PhysicsException if a law of the store may not be opened, or does not load
     * @throws CorruptException if it is no store, or of another world, or no image can be read
     */
    static StoredWorld open(Path file, SqliteStore.Durability durability,
            WorldDescription description, Pacing pacing, LawPath laws, Consumer<String> problems)
            throws IOException {
        SqliteStore store = new SqliteStore(file, durability);
        try {
            if (store.isEmpty()) {
                Simulation begun = new Simulation(description, pacing, laws);
                return new StoredWorld(begun, store, begun.physics().stateHash());
            }
            return resume(store, file, description, pacing, laws, problems);
        } catch (IOException | RuntimeException e) {
            store.close();
            throw e;
        }
    }

    private static StoredWorld resume(SqliteStore store, Path file,
            WorldDescription description, Pacing pacing, LawPath laws, Consumer<String> problems)
            throws IOException {
        List<JournalRecord> records = store.read(problems);
        try (Replay replay = new Replay(Optional.of(description), pacing, laws)) {
            boolean begun = false;
            for (JournalRecord record : records) {
                try {
                    if (!replay.take(record)) {
                        problems.accept(file + ": " + replay.divergence().orElseThrow().message()
                                + " from what was journalled; the world goes on as it is now");
                        break;
                    }
                } catch (PhysicsException refused) {
                    throw new PhysicsException(refused.status(),
                            file + ": " + refused.getMessage());
                } catch (CorruptException e) {
                    if (!begun) {
                        throw new CorruptException(file + ": " + e.getMessage());
                    }
                    problems.accept(file + ": " + e.getMessage()
                            + "; the world goes on from before that");
                    break;
                }
                begun |= record instanceof JournalRecord.Image;
            }
            Simulation resumed = replay.release();
            long stateHash = resumed.physics().stateHash();
            replay.members().forEach((agent, body) -> leave(resumed, agent, body));
            return new StoredWorld(resumed, store, stateHash);
        }
    }

    /** The agents' connections ended with the process that had them. */
    private static void leave(Simulation resumed, String agent, long body) {
        World world = resumed.world();
        Optional<Item> item = world.find(new ItemId(body));
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("agent", agent);
        fields.put("body", item.map(Item::name).orElse(""));
        fields.put("reason", "server-restarted");
        item.filter(own -> !resumed.description().agents().bodies().contains(own.name()))
                .ifPresent(own -> world.removeCascade(own.id()));
        world.raise(new WorldEvent(resumed.loop().frame() + 1, "left", fields));
    }
}
