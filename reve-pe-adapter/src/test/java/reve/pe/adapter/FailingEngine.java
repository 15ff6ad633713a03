// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.pe.LedgerLine;
import reve.pe.OwnColumn;
import reve.pe.PhysicalPropertyProvider;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.Prototype;
import reve.pe.Status;

import java.nio.file.Path;
import java.util.List;
import java.util.Map;

/**
 * An engine with bugs. While it is broken, it advances and then fails without naming a law; it
 * cannot prepare files called odd.so; and it can be set to refuse libraries.
 */
final class FailingEngine implements PhysicsEngine {
    private final PhysicsEngine engine;
    boolean broken;

    /** The time that the engine says it waited for a processor [ns]. */
    long waited;

    /** Number of libraries to refuse next. */
    int refusals;

    /** Number of libraries to load before one is refused; negative: none is refused. */
    int refuseAfter = -1;

    FailingEngine(PhysicsEngine engine) {
        this.engine = engine;
    }

    @Override
    public void advance(double dt, int steps) {
        engine.advance(dt, steps);
        if (broken) {
            throw new PhysicsException(Status.INTERNAL, "lost a step");
        }
    }

    @Override
    public PhysicalPropertyProvider propertyProvider() {
        return engine.propertyProvider();
    }

    @Override
    public Prototype prototype() {
        return engine.prototype();
    }

    @Override
    public PreparedLibrary prepare(String library) {
        return engine.prepare(library);
    }

    @Override
    public PreparedLibrary prepareText(String source, byte[] text) {
        return engine.prepareText(source, text);
    }

    @Override
    public String checkText(String source, byte[] text) {
        return engine.checkText(source, text);
    }

    @Override
    public PreparedLibrary prepare(Path file) {
        if (file.endsWith("odd.so")) {
            throw new IllegalStateException("odd name");
        }
        return engine.prepare(file);
    }

    @Override
    public int loadPhysicsLaw(PreparedLibrary prepared, Map<String, Double> parameters) {
        refuse(prepared);
        return engine.loadPhysicsLaw(prepared, parameters);
    }

    @Override
    public void replacePhysicsLaw(
            int libraryId, PreparedLibrary prepared, Map<String, Double> parameters) {
        refuse(prepared);
        engine.replacePhysicsLaw(libraryId, prepared, parameters);
    }

    @Override
    public PreparedLibrary prepare(byte[] library) {
        return engine.prepare(library);
    }

    private void refuse(PreparedLibrary prepared) {
        if (refusals > 0) {
            throw new PhysicsException(Status.INTERNAL, "refusals left: " + --refusals);
        }
        if (refuseAfter >= 0 && refuseAfter-- == 0) {
            throw new PhysicsException(Status.INTERNAL, "refused " + prepared.name());
        }
    }

    @Override
    public void unloadPhysicsLaw(int libraryId) {
        engine.unloadPhysicsLaw(libraryId);
    }

    @Override
    public List<double[]> ownValues(List<OwnColumn> columns, long row) {
        return engine.ownValues(columns, row);
    }

    @Override
    public void setInterval(int libraryId, int interval) {
        engine.setInterval(libraryId, interval);
    }

    @Override
    public void beginChanges() {
        engine.beginChanges();
    }

    @Override
    public void endChanges(boolean keep) {
        engine.endChanges(keep);
    }

    @Override
    public long waitedNanos() {
        return waited;
    }

    @Override
    public void readTimes(long[] into) {
        engine.readTimes(into);
    }

    @Override
    public List<PhysicsLaw> laws() {
        return engine.laws();
    }

    @Override
    public void clearFault() {
        engine.clearFault();
    }

    @Override
    public void moveRows(String kind, long[] moves) {
        engine.moveRows(kind, moves);
    }

    @Override
    public void setStepCount(long steps, double dtSeconds) {
        engine.setStepCount(steps, dtSeconds);
    }

    @Override
    public long stepCount() {
        return engine.stepCount();
    }

    @Override
    public byte[] saveState() {
        return engine.saveState();
    }

    @Override
    public void loadState(byte[] state) {
        engine.loadState(state);
    }

    @Override
    public long stateHash() {
        return engine.stateHash();
    }

    @Override
    public void setLedger(boolean on) {
        engine.setLedger(on);
    }

    @Override
    public List<LedgerLine> ledger() {
        return engine.ledger();
    }

    @Override
    public void close() {
        engine.close();
    }
}
