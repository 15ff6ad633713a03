// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.frame.Command;
import reve.core.frame.FrameEvent;
import reve.core.world.World;
import reve.pe.LawParameter;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;

import java.nio.file.Path;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.stream.Collectors;

/**
 * The active libraries of a {@link LawFolder}, by file. They change only by commands on the world's
 * thread.
 */
final class FolderLaws {
    private final String origin;
    private final Laws laws;
    private final Trials trials;
    private final Map<String, ActiveFile> byName = new HashMap<>();

    /** A change of the folder's laws. It is executed in ACT, the frame's phase for commands. */
    interface Change {
        void make(long frame);
    }

    /**
     * The library of a file that is active.
     *
     * @param parameters parameters from the YAML file beside the library, by name
     */
    private record ActiveFile(int libraryId, String sha256, Map<String, Double> parameters) {
        ActiveFile as(int newId) {
            return new ActiveFile(newId, sha256, parameters);
        }
    }

    /** A change in the command queue. */
    record Entry(String origin, long sequence, Change change) implements Command {

        @Override
        public void execute(World world, FrameEvent event) {
            change.make(event.frame());
        }
    }

    FolderLaws(String origin, Laws laws, Trials trials) {
        this.origin = origin;
        this.laws = laws;
        this.trials = trials;
    }

    /** A library that was read from a file, with the parameters of the file beside it. */
    record Put(Path file, PreparedLibrary library, FolderParameters parameters) {
        String name() {
            return file.getFileName().toString();
        }
    }

    /**
     * Activates the libraries of files that changed together, in place of their previous libraries.
     * Files may have exchanged their contents. A library that is refused at first is tried again
     * after the other libraries, on which it may depend. The previous library of a file stays if
     * its new library is refused again. New versions that need a trial take over later, together.
     *
     * @param puts new libraries; this method closes each one that neither the engine nor a trial
     *     takes
     */
    void put(long frame, List<Put> puts) {
        Map<Put, NewVersion> tried = new LinkedHashMap<>();
        try {
            adoptByName(puts);
            exchangeOwners(puts);
            Map<Put, PhysicsException> again = new LinkedHashMap<>();
            for (Put put : puts) {
                Optional<NewVersion> version = versionForTrial(put);
                if (version.isPresent()) {
                    tried.put(put, version.get());
                } else {
                    refusal(frame, put).ifPresent(why -> again.put(put, why));
                }
            }
            again.forEach(
                    (put, first) -> {
                        // A refused library is tried again only if no engine has taken it. The
                        // names of laws, which may be the reason for a refusal, are known only
                        // after an engine has taken the library.
                        boolean mayDependOnOthers = puts.size() > 1 && put.library.isFree();
                        Optional<PhysicsException> why =
                                mayDependOnOthers ? refusal(frame, put) : Optional.of(first);
                        why.ifPresent(each -> refuse(frame, put.name(), each));
                    });
            if (!tried.isEmpty()) {
                trials.begin(frame, List.copyOf(tried.values()));
            }
        } finally {
            puts.stream()
                    .filter(put -> !tried.containsKey(put) || tried.get(put).parametersOnly())
                    .forEach(put -> put.library.close());
        }
    }

    /**
     * Returns the new version of a loaded library, or its new parameters, if the files contain one
     * that needs a trial. The file counts as changed only when the version takes over.
     */
    private Optional<NewVersion> versionForTrial(Put put) {
        ActiveFile active = byName.get(put.name());
        if (active == null) {
            return Optional.empty();
        }
        ActiveFile old = followed(put.name(), active);
        PreparedLibrary library = put.library;
        FolderParameters parameters = put.parameters;
        if (!laws.isLoaded(old.libraryId)) {
            return Optional.empty();
        }
        if (old.sha256.equals(library.sha256())) {
            return parametersForTrial(put, old);
        }
        if (!trials.areDue(LawLibrary.of(library, parameters.values()))) {
            return Optional.empty();
        }
        ActiveFile next = new ActiveFile(old.libraryId, library.sha256(), parameters.values());
        return Optional.of(
                laws.newVersion(
                                old.libraryId,
                                library,
                                parameters.values(),
                                put.file,
                                parameters.check()::check)
                        .heardBy((at, refusal) -> tried(put.name(), old, next, refusal)));
    }

    /**
     * Returns the new parameters of a loaded library if they need a trial; empty if their unit is
     * wrong. A wrong unit is reported when the parameters are set without a trial.
     */
    private Optional<NewVersion> parametersForTrial(Put put, ActiveFile old) {
        FolderParameters wanted = put.parameters;
        if (old.parameters.equals(wanted.values()) || !trials.areDueForParameters()) {
            return Optional.empty();
        }
        List<PhysicsLaw> present = laws.lawsOf(old.libraryId);
        try {
            wanted.check().check(present);
        } catch (PhysicsException wrongUnit) {
            return Optional.empty();
        }
        ActiveFile next = new ActiveFile(old.libraryId, old.sha256, wanted.values());
        return Optional.of(
                laws.newParameters(
                                present.getFirst().library(),
                                changed(old.parameters, wanted, present))
                        .heardBy((at, refusal) -> tried(put.name(), old, next, refusal)));
    }

    /** Records that the version of a file has taken over, unless the file has changed meanwhile. */
    private void tried(
            String name, ActiveFile old, ActiveFile next, Optional<PhysicsException> refusal) {
        if (refusal.isPresent()) {
            return; // the trial has reported the refusal
        }
        String owner =
                byName.entrySet().stream()
                        .filter(file -> file.getValue().libraryId == old.libraryId)
                        .map(Map.Entry::getKey)
                        .findFirst()
                        .orElse(name);
        byName.put(owner, next);
        laws.leaveToFolder(old.libraryId);
    }

    /**
     * Assigns loaded libraries that a restored store contained to new files of the same names. Such
     * a file changed while no server ran, or its version was on trial when the server ended.
     */
    private void adoptByName(List<Put> puts) {
        for (Put put : puts) {
            if (byName.containsKey(put.name()) || free(put.library.sha256()).isPresent()) {
                continue;
            }
            laws.forFolderNamed(put.library.name(), owned()).stream()
                    .findFirst()
                    .ifPresent(
                            id -> {
                                LawLibrary present = laws.byId().get(id);
                                byName.put(
                                        put.name(),
                                        new ActiveFile(id, present.sha256(), present.parameters()));
                            });
        }
    }

    private Set<Integer> owned() {
        return byName.values().stream().map(ActiveFile::libraryId).collect(Collectors.toSet());
    }

    /**
     * Assigns to each of the files the loaded library whose name its new content declares. Only
     * libraries that already belong to one of the files are assigned.
     */
    private void exchangeOwners(List<Put> puts) {
        Map<String, ActiveFile> owned = new LinkedHashMap<>();
        for (Put put : puts) {
            ActiveFile active = byName.get(put.name());
            if (active != null) {
                owned.put(put.name(), followed(put.name(), active));
            }
        }
        Map<String, ActiveFile> left = new LinkedHashMap<>(owned);
        Map<String, ActiveFile> next = new LinkedHashMap<>();
        for (Put put : puts) {
            left.entrySet().stream()
                    .filter(one -> nameOf(one.getValue()).equals(put.library.name()))
                    .findFirst()
                    .map(Map.Entry::getKey)
                    .ifPresent(owner -> next.put(put.name(), left.remove(owner)));
        }
        for (Put put : puts) {
            // The other files keep their library, or get a library that has no owner now.
            boolean isLeft = owned.containsKey(put.name()) && !next.containsKey(put.name());
            if (isLeft && !left.isEmpty()) {
                String owner =
                        left.containsKey(put.name()) ? put.name() : left.keySet().iterator().next();
                next.put(put.name(), left.remove(owner));
            }
        }
        byName.keySet().removeAll(owned.keySet());
        byName.putAll(next);
        for (ActiveFile one : left.values()) {
            laws.leaveToFolder(one.libraryId);
        }
    }

    private String nameOf(ActiveFile file) {
        LawLibrary library = laws.byId().get(file.libraryId);
        return library == null ? "" : library.name();
    }

    /** Assigns libraries to the new names of files that were renamed. The libraries stay active. */
    void rename(Map<String, String> oldByNew) {
        Map<String, ActiveFile> moved = new LinkedHashMap<>();
        oldByNew.forEach(
                (name, old) -> {
                    ActiveFile file = byName.get(old);
                    if (file != null) {
                        moved.put(name, file);
                    }
                });
        byName.keySet().removeAll(oldByNew.values());
        byName.putAll(moved);
    }

    /** Activates the library of a file; returns why it was refused. */
    private Optional<PhysicsException> refusal(long frame, Put put) {
        String name = put.name();
        PreparedLibrary library = put.library;
        FolderParameters parameters = put.parameters;
        try {
            ActiveFile old = byName.get(name);
            if (old == null && adopted(name, library, parameters)) {
                return Optional.empty();
            }
            if (old != null) {
                old = followed(name, old);
                trials.cancel(frame, old.libraryId); // the file has changed again
            }
            if (old == null || !laws.isLoaded(old.libraryId)) {
                int id = load(frame, put.file, library, parameters);
                byName.put(name, new ActiveFile(id, library.sha256(), parameters.values()));
            } else if (!old.sha256.equals(library.sha256())) {
                laws.replace(
                        frame,
                        old.libraryId,
                        library,
                        parameters.values(),
                        put.file,
                        parameters.check()::check);
                byName.put(
                        name, new ActiveFile(old.libraryId, library.sha256(), parameters.values()));
                laws.leaveToFolder(old.libraryId);
            } else if (!old.parameters.equals(parameters.values())) {
                change(frame, name, old, parameters);
            }
            return Optional.empty();
        } catch (PhysicsException refusal) {
            return Optional.of(refusal);
        }
    }

    /**
     * Adopts an active library with the same bytes, which a restored store or the world file
     * loaded. The library keeps its parameters until the file with its parameters changes. Returns
     * false if there is no such library.
     */
    private boolean adopted(String name, PreparedLibrary library, FolderParameters parameters) {
        Optional<Integer> free = free(library.sha256());
        free.ifPresent(
                id -> byName.put(name, new ActiveFile(id, library.sha256(), parameters.values())));
        return free.isPresent();
    }

    /**
     * Returns the id of a loaded library with these bytes that does not come from a file of the
     * folder.
     */
    private Optional<Integer> free(String sha256) {
        Set<Integer> owned = owned();
        return laws.forFolder(sha256).stream().filter(id -> !owned.contains(id)).findFirst();
    }

    /**
     * Returns the active file with the present id of its library. A rewind may have loaded the
     * library again, with a new id.
     */
    private ActiveFile followed(String name, ActiveFile file) {
        if (laws.isLoaded(file.libraryId)) {
            return file;
        }
        ActiveFile found = free(file.sha256).map(file::as).orElse(file);
        byName.put(name, found);
        return found;
    }

    /** Loads a library, and checks the units of its parameters. */
    private int load(long frame, Path file, PreparedLibrary library, FolderParameters parameters) {
        int id = laws.load(frame, library, parameters.values(), file);
        try {
            parameters.check().check(laws.lawsOf(id));
            return id;
        } catch (PhysicsException wrong) {
            laws.unload(frame, id);
            throw wrong;
        }
    }

    /**
     * Changes the parameters of an active library to those in the changed file beside it.
     * Parameters that the file does not contain get their default.
     */
    private void change(long frame, String name, ActiveFile active, FolderParameters wanted) {
        List<PhysicsLaw> present = laws.lawsOf(active.libraryId);
        try {
            wanted.check().check(present);
            laws.setParameters(
                    frame,
                    present.getFirst().library(),
                    changed(active.parameters, wanted, present));
            byName.put(name, new ActiveFile(active.libraryId, active.sha256, wanted.values()));
        } catch (PhysicsException refusal) {
            refuse(frame, name, refusal);
        }
    }

    /**
     * Returns the values that give a library the wanted parameters: those of the file, and the
     * default of each parameter that the file contained before its change.
     */
    private static Map<String, Double> changed(
            Map<String, Double> before, FolderParameters wanted, List<PhysicsLaw> present) {
        Map<String, Double> changed = new LinkedHashMap<>();
        for (PhysicsLaw law : present) {
            for (LawParameter parameter : law.parameters()) {
                for (String known :
                        List.of(parameter.name(), law.name() + "." + parameter.name())) {
                    if (before.containsKey(known)) {
                        changed.put(known, parameter.standard());
                    }
                }
            }
        }
        changed.putAll(wanted.values());
        return changed;
    }

    /** Unloads the library of a removed file. */
    void remove(long frame, String name) {
        ActiveFile old = byName.get(name);
        if (old != null) {
            old = followed(name, old);
            trials.cancel(frame, old.libraryId);
            byName.remove(name);
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
}
