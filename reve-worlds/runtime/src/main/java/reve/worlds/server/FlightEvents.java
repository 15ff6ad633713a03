// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import jdk.jfr.Category;
import jdk.jfr.Description;
import jdk.jfr.Event;
import jdk.jfr.Label;
import jdk.jfr.Name;
import jdk.jfr.StackTrace;
import jdk.jfr.Timespan;

import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.pe.PhysicsLaw;
import reve.pe.adapter.PhysicsAdapter;

import java.util.List;

/**
 * Events for a recording of Java's flight recorder (JFR): one of each frame, and one of each law in
 * each frame. The events of a frame are written at the beginning of the next frame. Without a
 * recording, they cost two comparisons a frame. For the world's thread only.
 */
final class FlightEvents {
    private static final FramePhase[] PHASES = FramePhase.values();

    private final FrameLoop loop;
    private final PhysicsAdapter physics;
    private final Frame frame = new Frame();
    private final Law law = new Law();
    private final long[] phasesBefore = new long[PHASES.length];
    private long busyBefore;
    private long frameBefore = -1;

    FlightEvents(String world, FrameLoop loop, PhysicsAdapter physics) {
        this.loop = loop;
        this.physics = physics;
        frame.world = world;
        law.world = world;
    }

    /** A frame of a world. */
    @Name("reve.Frame")
    @Label("Frame")
    @Description("The time that the world's thread spent on a frame, and on each of its phases.")
    @Category("REVE")
    @StackTrace(false)
    private static final class Frame extends Event {
        @Label("World")
        private String world = "";

        @Label("Frame Number")
        private long frame;

        @Label("Busy Time")
        @Timespan
        private long busy;

        @Timespan private long intake;
        @Timespan private long act;
        @Timespan private long physics;
        @Timespan private long derive;
        @Timespan private long publish;
    }

    /** A law in a frame of a world. */
    @Name("reve.Law")
    @Label("Law")
    @Description("The time that a law took in a frame.")
    @Category("REVE")
    @StackTrace(false)
    private static final class Law extends Event {
        @Label("World")
        private String world = "";

        @Label("Frame Number")
        private long frame;

        @Label("Law")
        private String law = "";

        @Label("Time")
        @Timespan
        private long time;
    }

    /** Writes the events of the frame before. Called at the beginning of each frame. */
    void onFrame() {
        if (!frame.isEnabled() && !law.isEnabled()) {
            frameBefore = -1;
            return;
        }
        long number = loop.frame();
        if (number == frameBefore + 1 && frameBefore >= 0) {
            writeFrame(number);
            writeLaws(number);
        }
        frameBefore = number;
        busyBefore = loop.busyNanoseconds();
        for (int i = 0; i < PHASES.length; i++) {
            phasesBefore[i] = loop.phaseNanoseconds(PHASES[i]);
        }
    }

    private void writeFrame(long number) {
        frame.begin();
        frame.end();
        if (!frame.shouldCommit()) {
            return;
        }
        frame.frame = number;
        frame.busy = loop.busyNanoseconds() - busyBefore;
        frame.intake = since(FramePhase.INTAKE);
        frame.act = since(FramePhase.ACT);
        frame.physics = since(FramePhase.PHYSICS);
        frame.derive = since(FramePhase.DERIVE);
        frame.publish = since(FramePhase.PUBLISH);
        frame.commit();
    }

    private long since(FramePhase phase) {
        return loop.phaseNanoseconds(phase) - phasesBefore[phase.ordinal()];
    }

    private void writeLaws(long number) {
        if (!law.isEnabled()) {
            return;
        }
        law.frame = number;
        List<PhysicsLaw> laws = physics.laws().loaded();
        for (int i = 0; i < physics.timedLaws(); i++) {
            law.begin();
            law.end();
            if (law.shouldCommit()) {
                law.law = laws.get(i).name();
                law.time = physics.newestLawTime(i);
                law.commit();
            }
        }
    }
}
