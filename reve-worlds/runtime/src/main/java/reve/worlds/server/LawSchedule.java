// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.file.LawReference;
import reve.core.file.LawStep;
import reve.core.frame.FrameEvent;
import reve.core.frame.FrameListener;
import reve.core.frame.FramePhase;
import reve.core.text.Visible;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.Status;
import reve.pe.adapter.Laws;

import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Collection;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Changes of a simulation's laws at given frames. Each change is made in the phase ACT of its
 * frame. The loop stops after the frame of a refused change. Created and closed on the thread that
 * owns the world.
 */
public final class LawSchedule implements FrameListener, AutoCloseable {
    private final Simulation simulation;
    private final List<Prepared> steps = new ArrayList<>();
    private int next;
    private Optional<PhysicsException> failure = Optional.empty();

    /** A step, with its opened library if the step loads one. */
    private record Prepared(LawStep step, Optional<PreparedLibrary> library, Path file) {}

    /**
     * Opens all libraries that the steps load, and subscribes to the frames.
     *
     * @param steps the steps, in the order of their frames
     * @throws PhysicsException with the place of a step whose library cannot be opened
     */
    public LawSchedule(Simulation simulation, List<LawStep> steps) {
        this.simulation = simulation;
        try {
            for (LawStep step : steps) {
                this.steps.add(placed(step.law(), () -> prepare(step)));
            }
        } catch (RuntimeException refused) {
            close();
            throw refused;
        }
        if (!steps.isEmpty()) {
            simulation.bus().subscribe(FramePhase.ACT, "law schedule", this);
        }
    }

    private Prepared prepare(LawStep step) {
        String name = step.law().name();
        return switch (step.change()) {
            case LOAD ->
                    new Prepared(
                            step, Optional.of(simulation.prepare(name)), simulation.fileOf(name));
            case TEXT -> {
                String file = name + PreparedLibrary.TEXT_ENDING;
                byte[] text = step.law().text().orElseThrow().getBytes(StandardCharsets.UTF_8);
                String problems = simulation.engine().checkText(file, text);
                if (!problems.isEmpty()) {
                    throw new PhysicsException(Status.INVALID_ARGUMENT, problems);
                }
                yield new Prepared(
                        step,
                        Optional.of(simulation.engine().prepareText(file, text)),
                        Path.of(file));
            }
            case UNLOAD, SET -> new Prepared(step, Optional.empty(), Path.of(name));
        };
    }

    private interface Task<T> {
        T run();
    }

    /** Runs a task. Adds the place of the law in the file to the message if the law is refused. */
    private static <T> T placed(LawReference law, Task<T> task) {
        try {
            return task.run();
        } catch (PhysicsException refused) {
            throw new PhysicsException(
                    refused.status(), Visible.line(law.place()) + ": " + refused.getMessage());
        } catch (IllegalArgumentException refused) {
            throw new PhysicsException(
                    Status.INVALID_ARGUMENT,
                    Visible.line(law.place()) + ": " + refused.getMessage());
        }
    }

    /** Returns why a change was refused. For the world's thread only. */
    public Optional<PhysicsException> failure() {
        return failure;
    }

    @Override
    public void onFrame(FrameEvent frame) {
        while (failure.isEmpty()
                && next < steps.size()
                && steps.get(next).step.frame() <= frame.frame()) {
            Prepared due = steps.get(next++);
            try {
                placed(
                        due.step.law(),
                        () -> {
                            make(due, frame.frame());
                            return true;
                        });
            } catch (PhysicsException refused) {
                failure = Optional.of(refused);
                simulation.loop().stop();
            }
        }
    }

    private void make(Prepared due, long frame) {
        Laws laws = simulation.physics().laws();
        LawReference law = due.step.law();
        switch (due.step.change()) {
            case LOAD, TEXT -> {
                try (PreparedLibrary library = due.library.orElseThrow()) {
                    int id =
                            ServerControl.loadOrReplace(
                                    laws, frame, library, law.parameters(), due.file);
                    requireUnits(law, simulation.engine().laws(id));
                }
            }
            case UNLOAD -> laws.unload(frame, idOf(law.name()));
            case SET -> {
                requireUnits(law, simulation.engine().laws(idOf(law.name())));
                laws.setParameters(frame, law.name(), law.parameters());
            }
        }
    }

    private int idOf(String library) {
        List<PhysicsLaw> loaded = simulation.physics().laws().loaded();
        return loaded.stream()
                .filter(law -> law.library().equals(library))
                .mapToInt(PhysicsLaw::libraryId)
                .findFirst()
                .orElseThrow(
                        () ->
                                new IllegalArgumentException(
                                        "no law \""
                                                + library
                                                + "\" is loaded; loaded are "
                                                + loaded.stream()
                                                        .map(PhysicsLaw::library)
                                                        .distinct()
                                                        .toList()));
    }

    private static void requireUnits(LawReference law, List<PhysicsLaw> loaded) {
        Map<String, String> wrong = LawParameters.wrongUnits(law, loaded);
        if (!wrong.isEmpty()) {
            Collection<String> messages = wrong.values();
            throw new PhysicsException(Status.INVALID_ARGUMENT, String.join("\n", messages));
        }
    }

    /** Closes the libraries that were not loaded. */
    @Override
    public void close() {
        steps.subList(next, steps.size())
                .forEach(step -> step.library.ifPresent(PreparedLibrary::close));
        next = steps.size();
    }
}
