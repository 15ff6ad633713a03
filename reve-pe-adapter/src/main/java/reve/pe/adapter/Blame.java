// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.frame.FrameEvent;
import reve.core.world.ScalarType;
import reve.pe.Access;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PropertyUse;
import reve.pe.Status;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.ArrayList;
import java.util.Collections;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.regex.Pattern;
import java.util.stream.Collectors;

/**
 * Finds the library that is the cause if the numbers of a law are not finite. The law's own library
 * is the cause if the law computed these numbers from moderate numbers. Otherwise the law has read
 * extreme numbers that other laws write. The frame is then tried again without each other library,
 * and the cause is the library without which the frame succeeds. For the world's thread, after a
 * failure.
 */
final class Blame {
    /** Maximum number of trials in a frame. */
    private static final int MOST_TRIALS = 32;

    /** Magnitude above which f64 numbers are extreme: their higher powers are not finite. */
    private static final double EXTREME_F64 = 1e50;

    private static final float EXTREME_F32 = 1e12f;

    private static final Set<Access> READ = Set.of(Access.READ);

    private static final Pattern NUMBERS =
            Pattern.compile("wrote -?(nan|inf|[0-9.]+e\\+)|overflow");

    private final PhysicsEngine engine;
    private final Laws laws;
    private final BoundWorld bound;
    private final RollbackCopy rollback;

    Blame(PhysicsEngine engine, Laws laws, BoundWorld bound, RollbackCopy rollback) {
        this.engine = engine;
        this.laws = laws;
        this.bound = bound;
        this.rollback = rollback;
    }

    /**
     * Returns whether a law failed because of its numbers, and has read extreme numbers in a
     * property that it does not write itself. Called before the columns are restored.
     */
    boolean hasReadExtremes(PhysicsException failure) {
        return failure.status() == Status.LAW_MISBEHAVED
                && NUMBERS.matcher(String.valueOf(failure.getMessage())).find()
                && readsExtremes(failure);
    }

    /**
     * Returns the failure of the library that is the cause. The frame may succeed without any one
     * of several libraries. The cause is then the library among them that was loaded last. Returns
     * the given failure if there is no such library. The columns are those of the beginning of the
     * frame, before and after this call.
     */
    PhysicsException cause(FrameEvent frame, PhysicsException failure) {
        List<Map.Entry<Integer, LawLibrary>> others = new ArrayList<>(laws.byId().entrySet());
        others.removeIf(library -> library.getKey() == failure.libraryId());
        Collections.reverse(others);
        byte[] state = engine.saveState();
        for (Map.Entry<Integer, LawLibrary> other :
                others.subList(0, Math.min(MOST_TRIALS, others.size()))) {
            if (succeedsWithout(other.getKey(), other.getValue(), frame, state)) {
                return without(other.getKey(), other.getValue(), failure);
            }
        }
        return failure;
    }

    private boolean succeedsWithout(
            int libraryId, LawLibrary library, FrameEvent frame, byte[] state) {
        try {
            engine.setInterval(libraryId, 0);
        } catch (PhysicsException refused) {
            return false; // laws of this library keep columns on a device
        }
        boolean succeeded = false;
        try {
            engine.advance(frame.dtSeconds(), frame.steps());
            succeeded = true;
        } catch (PhysicsException failed) {
            engine.clearFault();
        }
        rollback.restore();
        engine.setInterval(libraryId, library.interval());
        if (succeeded) {
            engine.loadState(state);
        }
        return succeeded;
    }

    private PhysicsException without(int libraryId, LawLibrary library, PhysicsException failure) {
        List<String> names =
                laws.loaded().stream()
                        .filter(law -> law.libraryId() == libraryId)
                        .map(PhysicsLaw::name)
                        .toList();
        return new PhysicsException(
                failure.status(),
                libraryId,
                library.name(),
                names.size() == 1 ? names.getFirst() : "",
                failure.property(),
                failure.row().orElse(-1),
                "law "
                        + String.join(", ", names)
                        + ": its numbers make another law fail, and without it the frame succeeds: "
                        + failure.getMessage());
    }

    private boolean readsExtremes(PhysicsException failure) {
        Set<String> written =
                laws.loaded().stream()
                        .flatMap(law -> law.uses().stream())
                        .filter(use -> !use.access().equals(READ))
                        .map(PropertyUse::name)
                        .collect(Collectors.toSet());
        Set<String> read =
                laws.loaded().stream()
                        .filter(law -> law.libraryId() == failure.libraryId())
                        .filter(law -> law.name().equals(failure.law()))
                        .flatMap(law -> law.uses().stream())
                        .filter(use -> use.access().equals(READ))
                        .map(PropertyUse::name)
                        .filter(written::contains)
                        .collect(Collectors.toSet());
        return bound.columns(read).stream().anyMatch(Blame::hasExtreme);
    }

    private static boolean hasExtreme(BoundColumn column) {
        MemorySegment values = column.memory();
        if (column.type() == ScalarType.F64) {
            for (long at = 0; at < column.bytes(); at += Double.BYTES) {
                if (!(Math.abs(values.get(ValueLayout.JAVA_DOUBLE, at)) <= EXTREME_F64)) {
                    return true;
                }
            }
        } else if (column.type() == ScalarType.F32) {
            for (long at = 0; at < column.bytes(); at += Float.BYTES) {
                if (!(Math.abs(values.get(ValueLayout.JAVA_FLOAT, at)) <= EXTREME_F32)) {
                    return true;
                }
            }
        }
        return false;
    }
}
