// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.frame.TimeBudget;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Compares the times of libraries with their budgets. A decision changes the laws before the phase
 * PHYSICS of the next frame. The journal records the change in that frame, so a replay makes the
 * same change. For the world's thread only. Allocates nothing unless a budget is exceeded.
 */
final class BudgetWatch {
    /** Least number of frames between two warnings about the same library. */
    private static final int QUIET_FRAMES = 600;

    private final PhysicsEngine engine;
    private final Laws laws;
    private final LawTimes times;
    private final List<Excess> decided = new ArrayList<>();
    private boolean enforced;
    private long version = -1;
    private Watched[] watched = {};
    private long frame;

    /** A library with a budget. */
    private static final class Watched {
        private final int libraryId;
        private final int firstLaw;
        private final int lawCount;
        private final TimeBudget budget;

        /**
         * Number of successive frames up to the last frame in which the library exceeded its
         * budget.
         */
        private int over;

        private long quietUntil;

        Watched(int libraryId, int firstLaw, int lawCount, TimeBudget budget) {
            this.libraryId = libraryId;
            this.firstLaw = firstLaw;
            this.lawCount = lawCount;
            this.budget = budget;
        }
    }

    /**
     * A budget that was exceeded.
     *
     * @param nanoseconds time that the library took in the last frame [ns]
     */
    record Excess(int libraryId, TimeBudget budget, long nanoseconds) {}

    BudgetWatch(PhysicsEngine engine, Laws laws, LawTimes times) {
        this.engine = engine;
        this.laws = laws;
        this.times = times;
    }

    /** Sets whether budgets have an effect. */
    void enforce(boolean on) {
        enforced = on;
        forget();
    }

    /** Discards the data of all frames, and all decisions. */
    void forget() {
        decided.clear();
        version = -1;
    }

    /** Compares the times of the frame that has just been recorded. */
    void check(long ofFrame) {
        if (!enforced) {
            return;
        }
        frame = ofFrame;
        if (version != laws.version()) {
            follow();
        }
        long waited = watched.length == 0 ? 0 : Math.max(0, engine.waitedNanos());
        for (Watched library : watched) {
            long nanoseconds = -waited;
            for (int law = 0; law < library.lawCount; law++) {
                nanoseconds += times.newest(library.firstLaw + law);
            }
            library.over = nanoseconds > library.budget.nanoseconds() ? library.over + 1 : 0;
            if (library.over == library.budget.frames()) {
                library.over = 0;
                decide(library, nanoseconds);
            }
        }
    }

    private void decide(Watched library, long nanoseconds) {
        LawLibrary loaded = laws.byId().get(library.libraryId);
        boolean onlyWarns =
                library.budget.response() == TimeBudget.Response.WARN
                        || loaded != null && loaded.interval() == library.budget.every();
        if (onlyWarns) {
            if (frame < library.quietUntil) {
                return;
            }
            library.quietUntil = frame + QUIET_FRAMES;
        }
        decided.add(new Excess(library.libraryId, library.budget, nanoseconds));
    }

    /** Executes the decisions of the last frame. Called before PHYSICS. */
    void carryOut(long ofFrame) {
        if (decided.isEmpty()) {
            return;
        }
        List<Excess> excesses = List.copyOf(decided);
        decided.clear();
        for (Excess excess : excesses) {
            LawLibrary library = laws.byId().get(excess.libraryId);
            if (library != null && library.budget().equals(Optional.of(excess.budget))) {
                carryOut(ofFrame, excess, library);
            }
        }
    }

    private void carryOut(long ofFrame, Excess excess, LawLibrary library) {
        TimeBudget budget = excess.budget;
        switch (budget.response()) {
            case WARN -> report(ofFrame, excess, library, "");
            case UNLOAD -> {
                Optional<LawLibrary> back = laws.retire(ofFrame, excess.libraryId);
                String done =
                        back.map(old -> "; the version before it is back, SHA-256 " + old.sha256())
                                .orElse("; it is unloaded");
                report(ofFrame, excess, library, done);
            }
            case SKIP_STEPS -> {
                String done =
                        "; it is evaluated in every "
                                + budget.every()
                                + ". step"
                                + (library.interval() == budget.every() ? " already" : "");
                try {
                    laws.setInterval(excess.libraryId, budget.every());
                } catch (PhysicsException refused) {
                    done = "; " + refused.getMessage();
                }
                report(ofFrame, excess, library, done);
            }
        }
    }

    private void report(long ofFrame, Excess excess, LawLibrary library, String done) {
        laws.events().overBudget(ofFrame, library, excess.budget, excess.nanoseconds, done);
    }

    private void follow() {
        version = laws.version();
        List<PhysicsLaw> loaded = laws.loaded();
        List<Watched> found = new ArrayList<>();
        for (Map.Entry<Integer, LawLibrary> library : laws.byId().entrySet()) {
            if (library.getValue().budget().isPresent()) {
                int id = library.getKey();
                int first = 0;
                while (first < loaded.size() && loaded.get(first).libraryId() != id) {
                    first++;
                }
                int count = (int) loaded.stream().filter(law -> law.libraryId() == id).count();
                found.add(new Watched(id, first, count, library.getValue().budget().get()));
            }
        }
        watched = found.toArray(Watched[]::new);
    }
}
