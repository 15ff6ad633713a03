// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.frame.FramePhase;
import reve.core.frame.FrameProfile;
import reve.core.frame.Timing;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;
import reve.pe.PhysicsLaw;
import reve.pe.adapter.AdapterProfile;
import reve.pe.adapter.LawTime;

import java.io.PrintWriter;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.stream.IntStream;

/**
 * The result of a run.
 *
 * @param frames number of frames made
 * @param worldSeconds simulated time [s]
 * @param wallSeconds elapsed time [s]
 * @param stateHash hash, at the end, of all columns that laws can access
 * @param items number of items, without the one that holds the world's constants
 * @param bodies rows of kind {@code body} with physics; laws may read and write them
 * @param laws the laws that are loaded at the end, with their cost
 * @param lawTimes times of these laws in the last frames, in the same order
 * @param libraries all law libraries that were ever loaded, in order of loading
 * @param snapshotNanoseconds time for copying the world into snapshots [ns]
 */
public record RunReport(
        String world,
        long frames,
        double worldSeconds,
        double wallSeconds,
        long stateHash,
        int items,
        int bodies,
        List<PhysicsLaw> laws,
        List<LawTime> lawTimes,
        List<String> libraries,
        List<WorldEvent> faults,
        FrameProfile profile,
        AdapterProfile physics,
        long snapshotNanoseconds) {

    /** Copies the lists. */
    public RunReport {
        laws = List.copyOf(laws);
        lawTimes = List.copyOf(lawTimes);
        libraries = List.copyOf(libraries);
        faults = List.copyOf(faults);
    }

    /** Returns the report of a simulation between frames. For the world's thread only. */
    public static RunReport of(Simulation simulation, double wallSeconds) {
        World world = simulation.world();
        FrameProfile profile = simulation.loop().profile();
        Timing timing = simulation.description().timing();
        return new RunReport(
                world.name(),
                profile.frames(),
                timing.timeSeconds(profile.frames()),
                wallSeconds,
                simulation.physics().stateHash(),
                world.items().size() - 1,
                world.table(WorldPrototype.BODY).physicsRowCount(),
                simulation.physics().laws().loaded(),
                simulation.physics().lawTimes(),
                simulation.events().libraries(),
                simulation.events().faults(),
                profile,
                simulation.physics().profile(),
                simulation.snapshotNanoseconds());
    }

    /** Returns the simulated seconds per second of wall time. */
    public double realTimeFactor() {
        return worldSeconds / wallSeconds;
    }

    /** Returns the fields for JSON. */
    public Map<String, Object> fields() {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("world", world);
        fields.put("frames", frames);
        fields.put("worldSeconds", worldSeconds);
        fields.put("wallSeconds", wallSeconds);
        fields.put("realTimeFactor", realTimeFactor());
        fields.put("stateHash", hash());
        fields.put("items", items);
        fields.put("bodies", bodies);
        fields.put(
                "laws",
                IntStream.range(0, laws.size())
                        .mapToObj(i -> lawFields(laws.get(i), lawTimes.get(i)))
                        .toList());
        fields.put("libraries", libraries);
        fields.put("faults", faults.stream().map(WorldEvent::fields).toList());
        fields.put("profile", profileFields());
        return fields;
    }

    /** Prints a summary for human readers. */
    public void print(PrintWriter out) {
        out.printf(
                Locale.ROOT,
                "%s: %d frames, %.2f s of world time in %.2f s (%.1f x real time)%n",
                world,
                frames,
                worldSeconds,
                wallSeconds,
                realTimeFactor());
        out.printf(Locale.ROOT, "items: %d, of which %d are bodies with physics%n", items, bodies);
        for (PhysicsLaw law : laws) {
            out.printf(
                    Locale.ROOT,
                    "law %s %s (%s): %d calls, %.2f ms%n",
                    law.name(),
                    law.version(),
                    law.library(),
                    law.calls(),
                    law.nanoseconds() * 1e-6);
        }
        for (WorldEvent fault : faults) {
            out.println(line(fault));
        }
        out.printf(Locale.ROOT, "state hash: %s%n", hash());
    }

    /** Returns a fault as a line for human readers. */
    public static String line(WorldEvent fault) {
        Object file = fault.fields().getOrDefault("file", "");
        return "fault in frame "
                + fault.frame()
                + ": "
                + (file.equals("") ? "" : file + ": ")
                + fault.fields().get("message");
    }

    /** Prints one line for each part of a frame, with its busy time per frame and per body. */
    public void printProfile(PrintWriter out) {
        double busy = profile.busyNanoseconds();
        out.printf(Locale.ROOT, "%-24s %12s %12s %8s%n", "profile", "ns/frame", "ns/body", "share");
        for (Map.Entry<String, Long> part : parts().entrySet()) {
            double perFrame = part.getValue() / (double) Math.max(1, frames);
            out.printf(
                    Locale.ROOT,
                    "%-24s %12.0f %12.2f %7.1f%%%n",
                    part.getKey(),
                    perFrame,
                    perFrame / Math.max(1, bodies),
                    100 * part.getValue() / Math.max(1, busy));
        }
        printLaws(out);
    }

    /**
     * Prints one line for each law, with its time. These times are included in the line "PHYSICS
     * advance".
     */
    private void printLaws(PrintWriter out) {
        out.printf(
                Locale.ROOT,
                "%-24s %12s %12s %8s%n",
                "law",
                "p50 ns/frame",
                "p99 ns/frame",
                "share");
        for (int i = 0; i < laws.size(); i++) {
            LawTime time = lawTimes.get(i);
            out.printf(
                    Locale.ROOT,
                    "%-24s %12d %12d %7.1f%%%n",
                    laws.get(i).name(),
                    time.medianNanoseconds(),
                    time.p99Nanoseconds(),
                    100 * time.share());
        }
    }

    /**
     * Returns the parts of the busy time [ns]. The parts do not overlap. The phase PHYSICS is split
     * into the parts of the adapter's work.
     */
    Map<String, Long> parts() {
        Map<FramePhase, Long> phases = profile.phaseNanoseconds();
        Map<String, Long> parts = new LinkedHashMap<>();
        parts.put("INTAKE", phases.get(FramePhase.INTAKE));
        parts.put("ACT", phases.get(FramePhase.ACT));
        parts.put("PHYSICS bind", physics.bindNanoseconds());
        parts.put("PHYSICS rollback copy", physics.copyNanoseconds());
        parts.put("PHYSICS advance", physics.advanceNanoseconds());
        parts.put("DERIVE", phases.get(FramePhase.DERIVE));
        parts.put("PUBLISH snapshot copy", snapshotNanoseconds);
        parts.put("PUBLISH readers", phases.get(FramePhase.PUBLISH) - snapshotNanoseconds);
        long named = parts.values().stream().mapToLong(Long::longValue).sum();
        parts.put("rest", Math.max(0, profile.busyNanoseconds() - named));
        return parts;
    }

    private String hash() {
        return String.format(Locale.ROOT, "%016x", stateHash);
    }

    /** Returns the parts of the busy time for JSON. */
    Map<String, Object> profileFields() {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("busyNanoseconds", profile.busyNanoseconds());
        fields.put("overruns", profile.overruns());
        fields.put("droppedFrames", profile.droppedFrames());
        fields.put("redoneFrames", physics.redoneFrames());
        fields.put("nanoseconds", parts());
        return fields;
    }

    private static Map<String, Object> lawFields(PhysicsLaw law, LawTime time) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("library", law.library());
        fields.put("law", law.name());
        fields.put("version", law.version());
        fields.put("calls", law.calls());
        fields.put("nanoseconds", law.nanoseconds());
        fields.put("p50Nanoseconds", time.medianNanoseconds());
        fields.put("p99Nanoseconds", time.p99Nanoseconds());
        fields.put("share", time.share());
        return fields;
    }
}
