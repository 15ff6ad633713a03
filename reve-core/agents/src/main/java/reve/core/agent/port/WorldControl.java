// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

import reve.core.world.ActionRefused;
import reve.core.world.ItemId;
import reve.core.world.World;
import reve.core.world.WorldSnapshot;

import java.util.Collection;
import java.util.Map;
import java.util.function.Consumer;

/**
 * What the program that runs a world lets clients of the role control do, beside what every frame
 * loop can. Unless it says otherwise, a method is called on a connection's thread and may take its
 * time; the change that it returns is made on the world's thread, in ACT.
 */
public interface WorldControl {

    /** Something prepared that is to be done to a world. */
    @FunctionalInterface
    interface Change {
        /**
         * @throws ActionRefused with a code and a reason, if it cannot be done; nothing has
         *     happened then
         */
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

    /** The world as it was, to go back to. */
    interface Image extends AutoCloseable {
        /**
         * The world becomes as it was. World's thread, between frames.
         *
         * @return the next frame, which shows it so
         */
        long rewind();

        /**
         * Writes it as a world file, where the program keeps them. Any thread.
         *
         * @param file bare name, without a folder
         * @param without items to leave out, with all that is attached to them
         */
        void save(String file, Collection<ItemId> without) throws ActionRefused;

        /**
         * Lets a copy run ahead, which nobody else acts on; the world itself does not notice. Any
         * thread.
         *
         * @param frames to make
         * @param look sees the last of them
         */
        void foresee(int frames, Consumer<WorldSnapshot> look) throws ActionRefused;

        @Override
        void close();
    }

    /** The world as it was before anything happened; the program closes it. */
    Image beginning() throws ActionRefused;

    /** The world as it is now. World's thread, between frames; the caller closes it. */
    Image keep() throws ActionRefused;

    /** A program without laws, pictures or images. */
    static WorldControl none() {
        return NoControl.INSTANCE;
    }

    /** Refuses everything. */
    enum NoControl implements WorldControl {
        /** The only one. */
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

        @Override
        public Image beginning() throws ActionRefused {
            throw unsupported("images");
        }

        @Override
        public Image keep() throws ActionRefused {
            throw unsupported("images");
        }

        private static ActionRefused unsupported(String what) {
            return new ActionRefused("unsupported", "this server has no " + what);
        }
    }
}
