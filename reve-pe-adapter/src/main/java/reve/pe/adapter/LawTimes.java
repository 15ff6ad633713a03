// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.pe.PhysicsEngine;
import reve.pe.PhysicsLaw;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.function.LongSupplier;

/**
 * The times of the loaded laws in the last frames. The engine measures them; recording a frame
 * allocates nothing. For the world's thread only.
 */
final class LawTimes {
    /** Maximum number of frames that a report covers. */
    private static final int FRAMES = 1024;

    private static final double MEDIAN = 0.5;
    private static final double RARE = 0.99;

    private final PhysicsEngine engine;
    private final Laws laws;

    /** Returns the time that all frames have taken so far [ns]. */
    private LongSupplier busy;

    /** Value of {@code busy} at the beginning of each recorded frame, by its number % FRAMES. */
    private final long[] begun = new long[FRAMES];

    private long recorded;
    private long version = -1;
    private long[] before = {};
    private long[] totals = {};
    private Window[] windows = {};
    private Map<String, Window> byLaw = new HashMap<>();

    /** The times of a law [ns], by the number of the recorded frame % FRAMES. */
    private static final class Window {
        private final long[] nanoseconds = new long[FRAMES];

        /** The first recorded frame that contains this law. */
        private final long first;

        Window(long first) {
            this.first = first;
        }
    }

    LawTimes(PhysicsEngine engine, Laws laws, LongSupplier busy) {
        this.engine = engine;
        this.laws = laws;
        this.busy = busy;
    }

    /** Sets the clock of all frames, which returns their time so far [ns]. */
    void measureFrames(LongSupplier nanoseconds) {
        busy = nanoseconds;
        forget();
    }

    /** Discards the times of all frames. */
    void forget() {
        version = -1;
        byLaw.clear();
    }

    /** Records the beginning of a frame. */
    void begin() {
        follow();
        begun[at(recorded)] = busy.getAsLong();
    }

    /**
     * Records the end of a frame.
     *
     * @param whole false if the frame was repeated; the times of such a frame are not recorded
     * @return whether the frame is recorded
     */
    boolean end(boolean whole) {
        if (version != laws.version()) {
            return false; // a law failed, and was unloaded
        }
        engine.readTimes(totals);
        if (whole) {
            int at = at(recorded);
            for (int law = 0; law < windows.length; law++) {
                windows[law].nanoseconds[at] = totals[law] - before[law];
            }
            recorded++;
        }
        long[] read = totals;
        totals = before;
        before = read;
        return whole;
    }

    /** Returns the number of laws for which {@link #newest} is the time of the last frame. */
    int timed() {
        return recorded > 0 && version == laws.version() ? windows.length : 0;
    }

    /** Returns the time of a law in the newest recorded frame [ns]. */
    long newest(int law) {
        return windows[law].nanoseconds[at(recorded - 1)];
    }

    /** Returns the times of the loaded laws, in the order of {@link Laws#loaded}. */
    List<LawTime> report() {
        follow();
        List<LawTime> times = new ArrayList<>();
        for (Window window : windows) {
            times.add(report(window));
        }
        return times;
    }

    private LawTime report(Window window) {
        int frames = (int) Math.min(FRAMES, recorded - window.first);
        if (frames == 0) {
            return new LawTime(0, 0, 0, 0);
        }
        long[] sorted = new long[frames];
        for (int i = 0; i < frames; i++) {
            sorted[i] = window.nanoseconds[at(recorded - 1 - i)];
        }
        long span = busy.getAsLong() - begun[at(recorded - frames)];
        Arrays.sort(sorted);
        return new LawTime(
                frames,
                sorted[rank(MEDIAN, frames)],
                sorted[rank(RARE, frames)],
                Arrays.stream(sorted).sum() / (double) Math.max(1, span));
    }

    /**
     * Returns the index, in sorted values, of the smallest value that is at least as large as the
     * fraction {@code part} of all values.
     */
    private static int rank(double part, int count) {
        return (int) Math.ceil(part * count) - 1;
    }

    /**
     * Updates the list of laws after libraries were loaded or unloaded. A law that stays loaded
     * keeps its recorded frames.
     */
    private void follow() {
        if (version == laws.version()) {
            return;
        }
        version = laws.version();
        List<PhysicsLaw> loaded = laws.loaded();
        Map<Integer, LawLibrary> libraries = laws.byId();
        Map<String, Window> now = new HashMap<>();
        windows = new Window[loaded.size()];
        for (int i = 0; i < windows.length; i++) {
            PhysicsLaw law = loaded.get(i);
            LawLibrary library = libraries.get(law.libraryId());
            String key = (library == null ? "" : library.sha256()) + "/" + law.name();
            Window window = byLaw.getOrDefault(key, new Window(recorded));
            windows[i] = window;
            now.put(key, window);
        }
        byLaw = now;
        before = new long[windows.length];
        totals = new long[windows.length];
        engine.readTimes(before);
    }

    private static int at(long frame) {
        return (int) (frame % FRAMES);
    }
}
