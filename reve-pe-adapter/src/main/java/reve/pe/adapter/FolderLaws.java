// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import org.jspecify.annotations.Nullable;

import reve.core.frame.Command;
import reve.core.frame.FrameEvent;
import reve.core.world.World;
import reve.pe.PhysicsException;
import reve.pe.PreparedLibrary;
import reve.pe.Status;

import java.nio.file.Path;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;
import java.util.Queue;
import java.util.Set;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.stream.Collectors;

/**
 * Which file of a {@link LawFolder} is active as which library. Changes come as commands on the
 * world's thread; tracking works on any thread.
 */
final class FolderLaws implements AutoCloseable {
    private final Laws laws;
    private final Map<String, ActiveFile> byName = new HashMap<>();

    /** Everything prepared, so that what no engine took is dropped at the end. */
    private final Set<PreparedLibrary> tracked = new HashSet<>();

    private final Queue<SpareWanted> wanted = new ConcurrentLinkedQueue<>();

    /** A change to the folder's laws, made in ACT of a frame. */
    interface Change {
        void make(long frame);
    }

    /**
     * @param spare the same library once more: what to go back to if a successor is refused; null
     *     once it was used, until the folder has made another from the bytes
     */
    private record ActiveFile(
            int libraryId, String sha256, @Nullable PreparedLibrary spare, byte[] bytes) {}

    /** An active file whose spare was used. */
    record SpareWanted(String name, byte[] bytes) {}

    /** A change on its way through the command queue. */
    record Entry(long sequence, Change change) implements Command {
        @Override
        public String origin() {
            return LawFolder.ORIGIN;
        }

        @Override
        public void execute(World world, FrameEvent event) {
            change.make(event.frame());
        }
    }

    FolderLaws(Laws laws) {
        this.laws = laws;
    }

    synchronized PreparedLibrary track(PreparedLibrary prepared) {
        tracked.add(prepared);
        return prepared;
    }

    /** Takes one of the spares that are wanted, if any. */
    @Nullable SpareWanted nextWanted() {
        return wanted.poll();
    }

    void want(SpareWanted spare) {
        wanted.add(spare);
    }

    /** Keeps a spare that was wanted, if its file is still active without one. */
    void giveSpare(String name, PreparedLibrary spare) {
        ActiveFile file = byName.get(name);
        if (file != null && file.spare == null && file.sha256.equals(spare.sha256())) {
            byName.put(name, new ActiveFile(file.libraryId, file.sha256, spare, file.bytes));
        } else {
            drop(spare);
        }
    }

    /** Activates a file's library in place of what the file held before. */
    void put(long frame, Path file, PreparedLibrary library, PreparedLibrary spare) {
        String name = file.getFileName().toString();
        ActiveFile old = byName.get(name);
        if (old == null && adopted(name, library, spare)) {
            return;
        }
        boolean replaces = old != null && laws.isLoaded(old.libraryId);
        if (replaces && old.sha256.equals(library.sha256())) {
            drop(library);
            drop(spare);
            return;
        }
        try {
            int id =
                    replaces
                            ? replace(frame, file, old, library)
                            : laws.load(frame, library, Map.of(), file);
            untrack(library);
            if (old != null) {
                drop(old.spare);
            }
            byName.put(name, new ActiveFile(id, library.sha256(), spare, library.bytes()));
        } catch (PhysicsException refusal) {
            drop(library);
            drop(spare);
            refuse(frame, name, refusal);
            for (Throwable followed : refusal.getSuppressed()) {
                refuse(frame, name, (PhysicsException) followed);
            }
        }
    }

    /** Takes charge of the same library where it acts already: resumed, or named by the world. */
    private boolean adopted(String name, PreparedLibrary library, PreparedLibrary spare) {
        Set<Integer> owned =
                byName.values().stream().map(ActiveFile::libraryId).collect(Collectors.toSet());
        Optional<Integer> free =
                laws.forFolder(library.sha256()).stream()
                        .filter(id -> !owned.contains(id))
                        .findFirst();
        free.ifPresent(
                id -> {
                    byName.put(name, new ActiveFile(id, library.sha256(), spare, library.bytes()));
                    drop(library);
                });
        return free.isPresent();
    }

    /** Unloads what a removed file held. */
    void remove(long frame, String name) {
        ActiveFile old = byName.remove(name);
        if (old != null) {
            drop(old.spare);
            if (laws.isLoaded(old.libraryId)) {
                laws.unload(frame, old.libraryId);
            }
        }
    }

    /** Tells that a file does not act, and why. */
    void refuse(long frame, String name, PhysicsException refusal) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("source", LawFolder.ORIGIN);
        fields.put("file", name);
        laws.reportFault(frame, fields, refusal);
    }

    @Override
    public synchronized void close() {
        tracked.forEach(PreparedLibrary::close);
        tracked.clear();
    }

    /**
     * The two may not be loaded together (same name, same property integrated), so the old one goes
     * first, and comes back if the new one is refused.
     */
    private int replace(long frame, Path file, ActiveFile old, PreparedLibrary library) {
        String name = file.getFileName().toString();
        if (old.spare == null) {
            throw new PhysicsException(
                    Status.ALREADY_EXISTS,
                    name
                            + " was replaced"
                            + " too soon after an earlier replacement was refused; drop it again");
        }
        laws.unload(frame, old.libraryId);
        try {
            return laws.load(frame, library, Map.of(), file);
        } catch (PhysicsException refusal) {
            goBack(frame, name, old, old.spare, refusal);
            throw refusal;
        }
    }

    /** A failure to do so is told behind the refusal that led here. */
    private void goBack(
            long frame,
            String name,
            ActiveFile old,
            PreparedLibrary spare,
            PhysicsException refusal) {
        try {
            int back = laws.load(frame, spare, Map.of());
            untrack(spare);
            byName.put(name, new ActiveFile(back, old.sha256, null, old.bytes));
            want(new SpareWanted(name, old.bytes));
        } catch (PhysicsException e) {
            refusal.addSuppressed(e);
        }
    }

    /** Closes what no engine took. */
    void drop(@Nullable PreparedLibrary prepared) {
        if (prepared != null) {
            prepared.close();
            untrack(prepared);
        }
    }

    private synchronized void untrack(PreparedLibrary prepared) {
        tracked.remove(prepared);
    }
}
