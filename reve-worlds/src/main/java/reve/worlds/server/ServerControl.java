package reve.worlds.server;

import java.util.Map;
import java.util.regex.Pattern;
import org.jspecify.annotations.Nullable;
import reve.core.agent.WorldControl;
import reve.core.world.ActionRefused;
import reve.core.world.World;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.worlds.journal.SimulationImage;

/** What a server lets operators do over the network: laws by name, pictures, going back. */
final class ServerControl implements WorldControl, AutoCloseable {
    /** Never a path: who may control the world may not choose which files it runs. */
    private static final Pattern LIBRARY = Pattern.compile("[A-Za-z0-9_]{1,64}");

    private final Simulation simulation;
    private final Pictures pictures;
    private @Nullable SimulationImage beginning;

    ServerControl(Simulation simulation, Pictures pictures) {
        this.simulation = simulation;
        this.pictures = pictures;
    }

    @Override
    public Change loadLaw(String library, Map<String, Double> parameters) throws ActionRefused {
        if (!LIBRARY.matcher(library).matches()) {
            throw new ActionRefused("law-refused",
                    "\"" + library + "\" is no name of a library: letters, digits and _ only");
        }
        try {
            return new Load(simulation.engine().prepare(library), parameters);
        } catch (PhysicsException refused) {
            throw refusal(refused);
        }
    }

    @Override
    public Change unloadLaw(String library) {
        return (world, frame) -> {
            int id = simulation.physics().laws().loaded().stream()
                    .filter(law -> law.library().equals(library)).mapToInt(PhysicsLaw::libraryId)
                    .findFirst().orElseThrow(() -> new ActionRefused("law-refused",
                            "no library \"" + library + "\" is loaded"));
            simulation.physics().laws().unload(frame, id);
        };
    }

    @Override
    public Change picture() {
        return (world, frame) -> pictures.takeNext();
    }

    @Override
    public synchronized Image beginning() {
        if (beginning == null) {
            beginning = Simulation.beginning(simulation.description());
        }
        return new Kept(beginning);
    }

    @Override
    public Image keep() throws ActionRefused {
        try {
            return new Kept(simulation.keep());
        } catch (IllegalStateException full) {
            throw new ActionRefused("too-many-images", String.valueOf(full.getMessage()));
        }
    }

    @Override
    public synchronized void close() {
        if (beginning != null) {
            beginning.close();
        }
    }

    /** An image of this simulation. */
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
        public void close() {
            image.close();
        }
    }

    private static ActionRefused refusal(PhysicsException refused) {
        return new ActionRefused("law-refused", String.valueOf(refused.getMessage()));
    }

    /** A library that is open and waits to be activated. */
    private final class Load implements Change {
        private final PreparedLibrary prepared;
        private final Map<String, Double> parameters;

        Load(PreparedLibrary prepared, Map<String, Double> parameters) {
            this.prepared = prepared;
            this.parameters = parameters;
        }

        @Override
        public void make(World world, long frame) throws ActionRefused {
            try (prepared) {
                simulation.physics().laws().load(frame, prepared, parameters);
            } catch (PhysicsException refused) {
                throw refusal(refused);
            }
        }

        @Override
        public void drop() {
            prepared.close();
        }
    }
}
