// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/**
 * The list of loaded and quarantined libraries that results from changes of laws. It needs no
 * engine. For one thread.
 */
public final class LawList {
    private final List<LawLibrary> loaded = new ArrayList<>();
    private final Map<String, Quarantined> quarantined = new LinkedHashMap<>();

    /** Replaces the content by that of an image. */
    public void restore(List<LawLibrary> libraries, List<Quarantined> failed) {
        loaded.clear();
        loaded.addAll(libraries);
        quarantined.clear();
        failed.forEach(each -> quarantined.put(each.sha256(), each));
    }

    /**
     * Makes a change, as {@link Laws#apply} does with an engine.
     *
     * @throws IllegalArgumentException if the list has no library at the place of the change
     */
    public void apply(LawChange change) {
        switch (change) {
            case LawChange.Loaded added -> {
                quarantined.remove(added.library().sha256());
                loaded.add(added.library());
            }
            case LawChange.Replaced replaced -> set(replaced.place(), replaced.library());
            case LawChange.RolledBack back -> {
                set(back.place(), back.library());
                quarantine(back.reason());
            }
            case LawChange.Unloaded gone -> loaded.remove(checked(gone.place()));
            case LawChange.Failed failed -> {
                loaded.remove(checked(failed.place()));
                quarantine(failed.reason());
            }
            case LawChange.ParametersSet set ->
                    set(set.place(), at(set.place()).with(set.changed()));
            case LawChange.BudgetSet set ->
                    set(set.place(), at(set.place()).withBudget(set.budget()).withInterval(1));
            case LawChange.IntervalSet set ->
                    set(set.place(), at(set.place()).withInterval(set.interval()));
            case LawChange.Released released -> quarantined.remove(released.sha256());
            case LawChange.Arrested _, LawChange.Unmoved _ -> {}
        }
    }

    private void set(int place, LawLibrary library) {
        loaded.set(checked(place), library);
    }

    private LawLibrary at(int place) {
        return loaded.get(checked(place));
    }

    private void quarantine(Quarantined reason) {
        quarantined.put(reason.sha256(), reason);
    }

    private int checked(int place) {
        if (place < 0 || place >= loaded.size()) {
            throw new IllegalArgumentException(
                    "there is no law library in place "
                            + place
                            + ", "
                            + loaded.size()
                            + " are loaded");
        }
        return place;
    }

    /** Returns the loaded libraries, in the order of loading. */
    public List<LawLibrary> libraries() {
        return List.copyOf(loaded);
    }

    /** Returns the quarantined libraries, in the order of their failures. */
    public List<Quarantined> quarantined() {
        return List.copyOf(quarantined.values());
    }
}
