package reve.core.agent;

import java.util.Map;
import reve.core.world.ActionRefused;
import reve.core.world.World;

/**
 * What the program that runs a world lets clients of the role control do, beside what every frame loop can. Each
 * method is called on a connection's thread and may take its time; the change that it returns is made on the
 * world's thread, in ACT.
 */
public interface WorldControl {

    /** Something prepared that is to be done to a world. */
    @FunctionalInterface
    interface Change {
        /** @throws ActionRefused with a code and a reason, if it cannot be done; nothing has happened then */
        void make(World world, long frame) throws ActionRefused;

        /** Called instead if it will never be made. */
        default void drop() {}
    }

    /**
     * Loads a library of laws.
     *
     * @param library a bare name, searched where the program finds its laws
     * @param parameters of its laws, by {@code parameter} or {@code law.parameter}, in SI units
     */
    Change loadLaw(String library, Map<String, Double> parameters) throws ActionRefused;

    /** Unloads a library of laws by its name. */
    Change unloadLaw(String library) throws ActionRefused;

    /** Takes a picture of the frame. */
    Change picture() throws ActionRefused;

    /** A program without laws or pictures. */
    static WorldControl none() {
        return NoControl.INSTANCE;
    }

    /** Refuses everything. */
    enum NoControl implements WorldControl {
        INSTANCE;

        @Override
        public Change loadLaw(String library, Map<String, Double> parameters) throws ActionRefused {
            throw unsupported("laws");
        }

        @Override
        public Change unloadLaw(String library) throws ActionRefused {
            throw unsupported("laws");
        }

        @Override
        public Change picture() throws ActionRefused {
            throw unsupported("pictures");
        }

        private static ActionRefused unsupported(String what) {
            return new ActionRefused("unsupported", "this server has no " + what);
        }
    }
}
