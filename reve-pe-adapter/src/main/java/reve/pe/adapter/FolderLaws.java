// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import org.jspecify.annotations.Nullable;

import reve.core.frame.Command;
import reve.core.frame.FrameEvent;
import reve.core.world.World;
import reve.pe.LawParameter;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.Status;

import java.nio.file.Path;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Queue;
import java.util.Set;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.stream.Collectors;

/**
 * The active libraries of a {@link LawFolder}, by file. They change only by commands on the world's
 * thread; {@link #track} and {@link #drop} work on any thread.
 */
final class FolderLaws implements AutoCloseable {
    private final String origin;
    private final Laws laws;
    private final Map<String, ActiveFile> byName = new HashMap<>();

    /** All prepared libraries; those that no engine took are freed at the end. */
    private final Set<PreparedLibrary> tracked = new HashSet<>();

    private final Queue<SpareWanted> wanted = new ConcurrentLinkedQueue<>();

    /** A change of the folder's laws, executed in ACT, the frame's phase for commands. */
    interface Change {
        void make(long frame);
    }

    /**
     * @param spare a second prepared copy of the library, to restore it if its successor is
     *     refused; null after it was used, until the folder has prepared another one from {@code
     *     bytes}
     * @param parameters those of the file beside it, by name
     */
    private record ActiveFile(
            int libraryId,
            String sha256,
            @Nullable PreparedLibrary spare,
            byte[] bytes,
            Map<String, Double> parameters) {

        ActiveFile with(@Nullable PreparedLibrary newSpare) {
            return new ActiveFile(libraryId, sha256, newSpare, bytes, parameters);
        }

        ActiveFile as(int newId) {
            return new ActiveFile(newId, sha256, spare, bytes, parameters);
        }
    }

    /** An active file whose spare copy was used, so another one is wanted. */
    record SpareWanted(String name, byte[] bytes) {}

    /** A change in the command queue. */
    record Entry(String origin, long sequence, Change change) implements Command {

        @Override
        public void execute(World world, FrameEvent event) {
            change.make(event.frame());
        }
    }

    FolderLaws(String origin, Laws laws) {
        this.origin = origin;
        this.laws = laws;
    }

    synchronized PreparedLibrary track(PreparedLibrary prepared) {
        tracked.add(prepared);
        return prepared;
    }

    /** Returns an active file that needs a new spare copy; null if there is none. */
    @Nullable SpareWanted nextWanted() {
        return wanted.poll();
    }

    void want(SpareWanted spare) {
        wanted.add(spare);
    }

    /** Stores a new spare copy, if its file is still active without one. */
    void giveSpare(String name, PreparedLibrary spare) {
        ActiveFile file = byName.get(name);
        if (file != null && file.spare == null && file.sha256.equals(spare.sha256())) {
            byName.put(name, file.with(spare));
        } else {
            drop(spare);
        }
    }

    /** Activates the library of a file, in place of the file's previous library if there is one. */
    void put(
            long frame,
            Path file,
            PreparedLibrary library,
            PreparedLibrary spare,
            FolderParameters parameters) {
        String name = file.getFileName().toString();
        ActiveFile old = byName.get(name);
        if (old == null && adopted(name, library, spare, parameters)) {
            return;
        }
        if (old != null) {
            old = followed(name, old);
        }
        boolean replaces = old != null && laws.isLoaded(old.libraryId);
        if (replaces && old.sha256.equals(library.sha256())) {
            drop(library);
            drop(spare);
            if (!old.parameters.equals(parameters.values())) {
                change(frame, name, old, parameters);
            }
            return;
        }
        try {
            int id =
                    replaces
                            ? replace(frame, file, old, library, parameters)
                            : load(frame, file, library, parameters);
            untrack(library);
            if (old != null) {
                drop(old.spare);
            }
            byName.put(
                    name,
                    new ActiveFile(
                            id, library.sha256(), spare, library.bytes(), parameters.values()));
        } catch (PhysicsException refusal) {
            drop(library);
            drop(spare);
            refuse(frame, name, refusal);
            for (Throwable followed : refusal.getSuppressed()) {
                refuse(frame, name, (PhysicsException) followed);
            }
        }
    }

    /**
     * Adopts a library with the same bytes that is already active, because a store was restored or
     * the world file names it; it keeps its parameters until the file with them changes. Returns
     * false if there is none.
     */
    private boolean adopted(
            String name,
            PreparedLibrary library,
            PreparedLibrary spare,
            FolderParameters parameters) {
        Optional<Integer> free = free(library.sha256());
        free.ifPresent(
                id -> {
                    byName.put(
                            name,
                            new ActiveFile(
                                    id,
                                    library.sha256(),
                                    spare,
                                    library.bytes(),
                                    parameters.values()));
                    drop(library);
                });
        return free.isPresent();
    }

    /**
     * Returns the id of a loaded library with these bytes that does not come from a file of the
     * folder.
     */
    private Optional<Integer> free(String sha256) {
        Set<Integer> owned =
                byName.values().stream().map(ActiveFile::libraryId).collect(Collectors.toSet());
        return laws.forFolder(sha256).stream().filter(id -> !owned.contains(id)).findFirst();
    }

    /**
     * Returns the active file with the present id of its library: loading it again, for example
     * with other parameters, gives a library a new id.
     */
    private ActiveFile followed(String name, ActiveFile file) {
        if (laws.isLoaded(file.libraryId)) {
            return file;
        }
        ActiveFile found = free(file.sha256).map(file::as).orElse(file);
        byName.put(name, found);
        return found;
    }

    /** Loads a library whose parameters have units that fit. */
    private int load(long frame, Path file, PreparedLibrary library, FolderParameters parameters) {
        int id = laws.load(frame, library, parameters.values(), file);
        try {
            parameters.check().check(lawsOf(id));
            return id;
        } catch (PhysicsException wrong) {
            laws.unload(frame, id);
            throw wrong;
        }
    }

    private List<PhysicsLaw> lawsOf(int libraryId) {
        return laws.loaded().stream().filter(law -> law.libraryId() == libraryId).toList();
    }

    /**
     * Changes the parameters of an active library to those of the changed file beside it. Those
     * that the file no longer contains return to their default.
     */
    private void change(long frame, String name, ActiveFile active, FolderParameters wanted) {
        List<PhysicsLaw> present = lawsOf(active.libraryId);
        try {
            wanted.check().check(present);
            Map<String, Double> changed = new LinkedHashMap<>();
            for (PhysicsLaw law : present) {
                for (LawParameter parameter : law.parameters()) {
                    for (String known :
                            List.of(parameter.name(), law.name() + "." + parameter.name())) {
                        if (active.parameters.containsKey(known)) {
                            changed.put(known, parameter.standard());
                        }
                    }
                }
            }
            changed.putAll(wanted.values());
            laws.setParameters(frame, present.getFirst().library(), changed);
            ActiveFile now = followed(name, active);
            byName.put(
                    name,
                    new ActiveFile(
                            now.libraryId, now.sha256, now.spare, now.bytes, wanted.values()));
        } catch (PhysicsException refusal) {
            refuse(frame, name, refusal);
        }
    }

    /** Unloads the library of a removed file. */
    void remove(long frame, String name) {
        ActiveFile old = byName.get(name);
        if (old != null) {
            old = followed(name, old);
            byName.remove(name);
            drop(old.spare);
            if (laws.isLoaded(old.libraryId)) {
                laws.unload(frame, old.libraryId);
            }
        }
    }

    /** Reports that a file's library is not active, and why. */
    void refuse(long frame, String name, PhysicsException refusal) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("source", origin);
        fields.put("file", name);
        laws.reportFault(frame, fields, refusal);
    }

    @Override
    public synchronized void close() {
        tracked.forEach(PreparedLibrary::close);
        tracked.clear();
    }

    /**
     * Replaces a library. The two cannot be loaded at the same time, because they may have the same
     * name and integrate the same property. So the old one is unloaded first, and restored if the
     * engine refuses the new one.
     */
    private int replace(
            long frame,
            Path file,
            ActiveFile old,
            PreparedLibrary library,
            FolderParameters parameters) {
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
            return load(frame, file, library, parameters);
        } catch (PhysicsException refusal) {
            goBack(frame, name, old, old.spare, refusal);
            throw refusal;
        }
    }

    /** Restores the old library. If this fails, too, reports this failure after the refusal. */
    private void goBack(
            long frame,
            String name,
            ActiveFile old,
            PreparedLibrary spare,
            PhysicsException refusal) {
        try {
            int back = laws.load(frame, spare, old.parameters);
            untrack(spare);
            byName.put(name, old.as(back).with(null));
            want(new SpareWanted(name, old.bytes));
        } catch (PhysicsException e) {
            refusal.addSuppressed(e);
        }
    }

    /** Frees a library that no engine took. */
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
