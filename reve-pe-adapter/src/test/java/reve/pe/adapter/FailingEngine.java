package reve.pe.adapter;

import java.util.List;
import java.util.Map;
import reve.pe.PhysicalPropertyProvider;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.Prototype;
import reve.pe.Status;

/** An engine with a bug: while it is broken, it advances and then fails, blaming no law. */
final class FailingEngine implements PhysicsEngine {
    private final PhysicsEngine engine;
    boolean broken;

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
    public int loadPhysicsLaw(PreparedLibrary prepared, Map<String, Double> parameters) {
        return engine.loadPhysicsLaw(prepared, parameters);
    }

    @Override
    public void unloadPhysicsLaw(int libraryId) {
        engine.unloadPhysicsLaw(libraryId);
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
    public long stepCount() {
        return engine.stepCount();
    }

    @Override
    public long stateHash() {
        return engine.stateHash();
    }

    @Override
    public void close() {
        engine.close();
    }
}
