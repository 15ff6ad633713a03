// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.core.agent.port.ClusterPort;
import reve.core.agent.port.WorldControl;
import reve.core.disk.Reason;
import reve.core.file.EditReader;
import reve.core.file.WorldFile;
import reve.core.file.WorldWriter;
import reve.core.frame.LawSwap;
import reve.core.frame.TimeBudget;
import reve.core.world.ActionRefused;
import reve.core.world.Departure;
import reve.core.world.Item;
import reve.core.world.ItemId;
import reve.core.world.World;
import reve.core.world.WorldSnapshot;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.adapter.Laws;
import reve.pe.adapter.Quarantined;
import reve.worlds.journal.SimulationImage;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Collection;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalInt;
import java.util.function.Consumer;
import java.util.function.Supplier;
import java.util.regex.Pattern;

/**
 * The operations that a server offers to operators over the network: loading laws by name, taking
 * pictures, rewinding, saving and forking.
 */
final class ServerControl implements WorldControl, AutoCloseable {
    private static final Logger LOG = LoggerFactory.getLogger("reve.control");

    /**
     * Permitted names of laws. They exclude paths, because a remote operator must not choose which
     * files the server runs.
     */
    private static final Pattern LIBRARY = Pattern.compile("[A-Za-z0-9_]{1,64}(\\.law|\\.py)?");

    /** Permitted names for laws that are sent as text. */
    private static final Pattern SOURCE = Pattern.compile("[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}");

    /** Permitted names of world files. They exclude paths. */
    private static final Pattern FILE = Pattern.compile("[A-Za-z0-9][A-Za-z0-9_-]{0,63}");

    private static final long FORESEE_NANOSECONDS = 10_000_000_000L;

    private final Simulation simulation;
    private final Pictures pictures;
    private final Shadows shadows;
    private final Optional<Path> saves;
    private final ServerEvents events;
    private final Ledger ledger;
    private final LawEquations equations = new LawEquations();
    private final LawTrust trust;
    private final WorldAnswers answers;
    private final Supplier<Optional<ClusterPort>> cluster;
    private @Nullable SimulationImage beginning;

    /**
     * Creates the operations for one world.
     *
     * @param saves folder for world files; empty if saving is not permitted
     * @param shadows trials of new versions of laws
     * @param cluster returns the cluster to which the server belongs
     */
    ServerControl(
            Simulation simulation,
            Pictures pictures,
            Optional<Path> saves,
            ServerEvents events,
            Shadows shadows,
            Supplier<Optional<ClusterPort>> cluster) {
        this.simulation = simulation;
        this.shadows = shadows;
        this.pictures = pictures;
        this.saves = saves;
        this.events = events;
        this.ledger = new Ledger(simulation.physics());
        this.cluster = cluster;
        this.answers = new WorldAnswers(simulation, cluster);
        this.trust = new LawTrust(simulation.shippedLaws());
    }

    @Override
    public Change loadLaw(String library, Map<String, Double> parameters, Optional<LawSwap> swap)
            throws ActionRefused {
        if (!LIBRARY.matcher(library).matches()) {
            throw new ActionRefused(
                    "law-refused",
                    "\"" + library + "\" is no name of a library: letters, digits and _ only");
        }
        try {
            return new Load(
                    simulation.prepare(library), parameters, simulation.fileOf(library), swap);
        } catch (PhysicsException failed) {
            LOG.warn(
                    "the law library {} was asked for and refused: {}",
                    library,
                    failed.getMessage());
            LOG.debug("the law library {}", library, failed);
            throw new ActionRefused(
                    "law-refused", simulation.reasonForClients(library, failed), failed);
        }
    }

    @Override
    public Change loadText(
            String source, String text, Map<String, Double> parameters, Optional<LawSwap> swap)
            throws ActionRefused {
        if (!SOURCE.matcher(source).matches()) {
            throw new ActionRefused(
                    "law-refused",
                    "\""
                            + source
                            + "\" is no name of a text: letters, digits, _, - and . only, 64 at"
                            + " most");
        }
        byte[] bytes = text.getBytes(StandardCharsets.UTF_8);
        if (source.endsWith(PreparedLibrary.PYTHON_ENDING) || PreparedLibrary.isPython(bytes)) {
            throw new ActionRefused(
                    "law-refused",
                    source
                            + " is in Python and would run with all rights of the server's account,"
                            + " so the server takes it from no client: copy it into the server's"
                            + " folder of --laws");
        }
        try {
            String problems = simulation.engine().checkText(source, bytes);
            if (!problems.isEmpty()) {
                throw new ActionRefused("law-refused", problems);
            }
            return new Load(
                    simulation.engine().prepareText(source, bytes),
                    parameters,
                    Path.of(source),
                    swap);
        } catch (PhysicsException failed) {
            throw refusal(failed);
        }
    }

    @Override
    public Change unloadLaw(String library) {
        return (world, frame) -> {
            int id =
                    simulation.physics().laws().loaded().stream()
                            .filter(law -> law.library().equals(library))
                            .mapToInt(PhysicsLaw::libraryId)
                            .findFirst()
                            .orElseThrow(
                                    () ->
                                            new ActionRefused(
                                                    "law-refused",
                                                    simulation
                                                            .physics()
                                                            .laws()
                                                            .notLoaded(library)));
            simulation.physics().laws().unload(frame, id);
        };
    }

    @Override
    public Change setLaw(String library, Map<String, Double> parameters, Optional<LawSwap> swap) {
        return (world, frame) -> {
            Laws laws = simulation.physics().laws();
            try {
                if (shadows.areDueForParameters(swap)) {
                    shadows.begin(frame, List.of(laws.newParameters(library, parameters)));
                } else {
                    laws.setParameters(frame, library, parameters);
                }
            } catch (IllegalArgumentException unknown) {
                throw new ActionRefused("law-refused", String.valueOf(unknown.getMessage()));
            } catch (PhysicsException refused) {
                throw refusal(refused);
            }
        };
    }

    @Override
    public Change setBudget(String library, Optional<TimeBudget> budget) {
        return (world, frame) -> {
            try {
                simulation.physics().laws().setBudget(library, budget);
            } catch (IllegalArgumentException unknown) {
                throw new ActionRefused("law-refused", String.valueOf(unknown.getMessage()));
            } catch (PhysicsException refused) {
                throw refusal(refused);
            }
        };
    }

    @Override
    public Reading laws(boolean faults) {
        List<String> available = simulation.lawNames();
        equations.read(available);
        trust.read();
        return () ->
                new LawReport(equations, trust)
                        .of(simulation.physics(), available, faults, shadows.report());
    }

    @Override
    public Map<String, Object> lawColumns(String item) {
        Optional<Item> found = simulation.world().find(item);
        try {
            return found.isEmpty()
                    ? Map.of()
                    : LawReport.columns(simulation.physics().lawColumns(found.get()));
        } catch (PhysicsException | IllegalStateException lost) {
            LOG.debug("the columns of laws of {} cannot be read", item, lost);
            return Map.of(); // the engine is being replaced
        }
    }

    @Override
    public Map<String, Object> ledger(Optional<Boolean> open) throws ActionRefused {
        try {
            return ledger.report(open);
        } catch (PhysicsException refused) {
            throw refusal(refused);
        }
    }

    @Override
    public Change picture() {
        return new Change() {
            private String file = "";

            @Override
            public void make(World world, long frame) {
                pictures.takeNext();
                file = Pictures.fileName(world.name(), frame);
            }

            @Override
            public Optional<Object> value() {
                return Optional.of(Map.of("file", file));
            }
        };
    }

    @Override
    public Change release(String library) {
        return (world, frame) -> {
            Quarantined found =
                    simulation.physics().laws().quarantined().stream()
                            .filter(each -> each.library().equals(library))
                            .findFirst()
                            .orElseThrow(
                                    () ->
                                            new ActionRefused(
                                                    "law-refused",
                                                    "no library \""
                                                            + library
                                                            + "\" is in quarantine"));
            simulation.physics().laws().release(found.sha256());
        };
    }

    @Override
    public Object answer(String what, Map<String, Object> arguments) throws ActionRefused {
        return answers.answer(what, arguments);
    }

    @Override
    public Optional<ClusterPort> cluster() {
        return cluster.get();
    }

    @Override
    public Change changeRules(Map<String, Optional<String>> rules) {
        return (world, frame) ->
                simulation.setRules(
                        new EditReader(world.prototype())
                                .rules(simulation.description().rules(), rules));
    }

    @Override
    public synchronized Image beginning() {
        if (beginning == null) {
            beginning = simulation.beginning();
        }
        return new Kept(beginning);
    }

    @Override
    public Image keep() throws ActionRefused {
        try {
            return new Kept(simulation.keep());
        } catch (IllegalStateException failed) {
            LOG.warn("no image of the world is kept: {}", failed.getMessage());
            throw simulation.hasRoomForImage()
                    ? new ActionRefused(
                            "action-failed",
                            "the state of the laws cannot be read now; the server's log says why",
                            failed)
                    : new ActionRefused(
                            "too-many-images",
                            "the images that are kept take all the memory there is for them;"
                                    + " a snapshot under one of their names replaces it",
                            failed);
        }
    }

    @Override
    public synchronized void close() {
        if (beginning != null) {
            beginning.close();
        }
    }

    /**
     * An image of this simulation to which a client has given a name. It is used for rewinding and
     * forks.
     */
    private final class Kept implements Image {
        private final SimulationImage image;

        Kept(SimulationImage image) {
            this.image = image;
        }

        @Override
        public long rewind() {
            return simulation.rewind(image);
        }

        @Override
        public void save(String file, Collection<ItemId> without) throws ActionRefused {
            Path folder =
                    saves.orElseThrow(
                            () ->
                                    new ActionRefused(
                                            "unsupported",
                                            "this server saves no worlds; start it with --saves"
                                                    + " DIR"));
            if (!FILE.matcher(file).matches()) {
                throw new ActionRefused(
                        "save-refused",
                        "\""
                                + file
                                + "\" is no name of a file: "
                                + "expected letters, digits, _ and - only, without .yaml");
            }
            Path target = folder.resolve(file + ".yaml");
            try (Simulation fork = simulation.fork(image)) {
                List<String> lost = new ArrayList<>();
                without.forEach(body -> lost.addAll(removed(fork.world(), body)));
                WorldFile.save(target, fork.descriptionNow());
                lost.addAll(fork.notDescribed());
                Map<String, Object> fields = new LinkedHashMap<>();
                fields.put("frame", image.frame());
                fields.put("file", target.toAbsolutePath().normalize().toString());
                fields.put("without", lost);
                events.happened("saved", fields);
            } catch (IOException | IllegalArgumentException | PhysicsException failed) {
                LOG.warn("the world cannot be saved as {}: {}", target, Reason.of(failed));
                LOG.debug("the file {}", target, failed);
                throw new ActionRefused(
                        "save-refused",
                        "the world cannot be saved as " + file + LawPath.SEE_LOG,
                        failed);
            }
        }

        @Override
        public void foresee(int frames, Change first, Consumer<WorldSnapshot> look)
                throws ActionRefused {
            try (Simulation fork = simulation.fork(image)) {
                long deadline = System.nanoTime() + FORESEE_NANOSECONDS;
                fork.loop().run(0);
                first.make(fork.world(), fork.loop().frame());
                for (int made = 0; made < frames; made++) {
                    if (System.nanoTime() > deadline) {
                        throw new ActionRefused(
                                "fork-refused",
                                "the copy has made "
                                        + made
                                        + " of "
                                        + frames
                                        + " frames in "
                                        + FORESEE_NANOSECONDS / 1_000_000_000
                                        + " s, which is the most it may take");
                    }
                    fork.loop().step();
                }
                try (WorldSnapshot snapshot = fork.snapshots().acquireLatest().orElseThrow()) {
                    look.accept(snapshot);
                }
            } catch (PhysicsException failed) {
                throw new ActionRefused("fork-refused", String.valueOf(failed.getMessage()));
            }
        }

        @Override
        public void close() {
            image.close();
        }
    }

    /**
     * Removes an agent's body from a world, and returns the names of the items removed with it. The
     * agent may have removed its body already.
     */
    private static List<String> removed(World world, ItemId body) {
        if (world.find(body).isEmpty()) {
            return List.of();
        }
        String name = world.item(body).name();
        return Departure.of(world, body).removed().stream()
                .map(item -> "the item " + item + ", which refers to " + name)
                .toList();
    }

    /**
     * Loads a library, or replaces a loaded library. A text replaces the loaded text of the same
     * name. A library in native code or in Python replaces a loaded library of the same name with
     * other bytes. The old library stays loaded if the engine refuses the new library. For the
     * world's thread, outside PHYSICS.
     *
     * @return id of the library
     */
    static int loadOrReplace(
            Laws laws,
            long frame,
            PreparedLibrary prepared,
            Map<String, Double> parameters,
            Path file) {
        OptionalInt old = toReplace(laws, prepared);
        if (old.isEmpty()) {
            return laws.load(frame, prepared, parameters, file);
        }
        laws.replace(frame, old.getAsInt(), prepared, parameters, file, made -> {});
        return old.getAsInt();
    }

    /**
     * Returns the id of the loaded library that a prepared library replaces; empty if there is
     * none.
     */
    private static OptionalInt toReplace(Laws laws, PreparedLibrary prepared) {
        boolean text = PreparedLibrary.isText(prepared.bytes());
        return laws.byId().entrySet().stream()
                .filter(loaded -> loaded.getValue().name().equals(prepared.name()))
                .filter(loaded -> loaded.getValue().isText() == text)
                .filter(loaded -> text || !loaded.getValue().sha256().equals(prepared.sha256()))
                .mapToInt(Map.Entry::getKey)
                .findFirst();
    }

    private static ActionRefused refusal(PhysicsException refused) {
        return new ActionRefused("law-refused", String.valueOf(refused.getMessage()));
    }

    /** A prepared library. It waits until the world's thread activates it. */
    private final class Load implements Change {
        private final PreparedLibrary prepared;
        private final Map<String, Double> parameters;
        private final Path file;
        private final Optional<LawSwap> swap;

        Load(
                PreparedLibrary prepared,
                Map<String, Double> parameters,
                Path file,
                Optional<LawSwap> swap) {
            this.prepared = prepared;
            this.file = file;
            this.parameters = parameters;
            this.swap = swap;
        }

        @Override
        public void make(World world, long frame) throws ActionRefused {
            Laws laws = simulation.physics().laws();
            OptionalInt old = toReplace(laws, prepared);
            if (old.isPresent() && shadows.areDue(PreparedLibrary.isText(prepared.bytes()), swap)) {
                shadows.begin(
                        frame,
                        List.of(
                                laws.newVersion(
                                        old.getAsInt(), prepared, parameters, file, made -> {})));
                return;
            }
            try (prepared) {
                if (old.isEmpty() && laws.libraries().size() >= WorldWriter.MAX_LAWS) {
                    throw new ActionRefused(
                            "law-refused",
                            "the world has "
                                    + laws.libraries().size()
                                    + " laws, the most that a world file holds is "
                                    + WorldWriter.MAX_LAWS
                                    + "; unload one first");
                }
                old.ifPresent(id -> shadows.cancel(frame, id));
                loadOrReplace(laws, frame, prepared, parameters, file);
            } catch (PhysicsException refused) {
                throw refusal(refused);
            }
        }

        @Override
        public Optional<String> library() {
            return Optional.of(prepared.name());
        }

        @Override
        public void drop() {
            prepared.close();
        }
    }
}
