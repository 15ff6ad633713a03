// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

import reve.core.world.ActionRefused;
import reve.core.world.ItemId;
import reve.core.world.World;
import reve.core.world.WorldSnapshot;

import java.util.Collection;
import java.util.Map;
import java.util.Optional;
import java.util.function.Consumer;

/**
 * What the program that runs a world permits clients of the role control to do, besides the
 * commands of every frame loop. Unless stated otherwise, methods are called on a connection's
 * thread and may block; the returned change is made on the world's thread, in ACT.
 */
public interface WorldControl {

    /** A prepared change of a world. */
    @FunctionalInterface
    interface Change {
        /**
         * Makes the change.
         *
         * @throws ActionRefused with a code and a reason if it is not possible; the world is then
         *     unchanged
         */
        void make(World world, long frame) throws ActionRefused;

        /** Called instead of {@link #make} if the change is never made. */
        default void drop() {}
    }

    /**
     * Prepares loading a library of laws.
     *
     * @param library name without a folder; the program searches its law folders
     * @param parameters of its laws, by {@code parameter} or {@code law.parameter}, in SI units
     */
    Change loadLaw(String library, Map<String, Double> parameters) throws ActionRefused;

    /**
     * Prepares loading a law as text. It replaces a loaded text of the same name.
     *
     * @param source name of the text in messages, such as "wind.law"
     * @param parameters of its laws, by {@code parameter} or {@code law.parameter}, in SI units
     * @throws ActionRefused with all problems of the text and their lines
     */
    Change loadText(String source, String text, Map<String, Double> parameters)
            throws ActionRefused;

    /** Prepares unloading a library of laws by its name. */
    Change unloadLaw(String library) throws ActionRefused;

    /**
     * Prepares other parameters of a loaded library, which keeps its place among the laws.
     *
     * @param parameters as in {@link #loadLaw}; the others keep their values
     */
    Change setLaw(String library, Map<String, Double> parameters) throws ActionRefused;

    /** A prepared report about a world. */
    @FunctionalInterface
    interface Reading {
        /** Reads the world. World's thread, between frames. */
        Map<String, Object> read() throws ActionRefused;
    }

    /**
     * Prepares a report of the loaded, quarantined and available laws.
     *
     * @param faults whether to include messages of faults, which may name files of the server
     */
    Reading laws(boolean faults) throws ActionRefused;

    /**
     * Returns the ledger of energy and momentum for a report, after opening or closing it. World's
     * thread, between frames.
     *
     * @param open true opens or restarts the ledger, false closes it
     */
    Map<String, Object> ledger(Optional<Boolean> open) throws ActionRefused;

    /** Prepares a picture of the frame. */
    Change picture() throws ActionRefused;

    /**
     * Prepares new rules, all of them or none.
     *
     * @param rules by the symbol that each computes: the rule as in a world file, in JSON; empty
     *     removes the rule
     */
    Change changeRules(Map<String, Optional<String>> rules) throws ActionRefused;

    /** Prepares the end of a library's quarantine. */
    Change release(String library) throws ActionRefused;

    /**
     * Answers a question about the world. World's thread, between frames.
     *
     * @param what the type of the message in the protocol, such as {@code near}
     * @param arguments Double, List of Double, String or Boolean by name
     * @return a List or Map by text of String, Boolean, Number, or lists and maps of these
     */
    Object answer(String what, Map<String, Object> arguments) throws ActionRefused;

    /** A saved state of the world, to which it can be rewound. */
    interface Image extends AutoCloseable {
        /**
         * Restores the world to this state. World's thread, between frames.
         *
         * @return the next frame, which shows the restored state
         */
        long rewind();

        /**
         * Writes the state as a world file into the program's folder. Any thread.
         *
         * @param file name without a folder
         * @param without items to omit, with all items attached to them
         */
        void save(String file, Collection<ItemId> without) throws ActionRefused;

        /**
         * Advances a copy of the world, which receives no commands; the world itself is not
         * affected. Any thread.
         *
         * @param frames to make
         * @param first change that is made in the copy before its first frame
         * @param look receives the last frame
         */
        void foresee(int frames, Change first, Consumer<WorldSnapshot> look) throws ActionRefused;

        @Override
        void close();
    }

    /** Returns the state of the world at its start. The program closes it. */
    Image beginning() throws ActionRefused;

    /**
     * Returns the present state of the world. World's thread, between frames; the caller closes it.
     */
    Image keep() throws ActionRefused;

    /** Returns an implementation for a program without laws, pictures or images. */
    static WorldControl none() {
        return NoControl.INSTANCE;
    }

    /** Refuses everything. */
    enum NoControl implements WorldControl {
        /** The only instance. */
        INSTANCE;

        @Override
        public Change loadLaw(String library, Map<String, Double> parameters) throws ActionRefused {
            throw unsupported("laws");
        }

        @Override
        public Change loadText(String source, String text, Map<String, Double> parameters)
                throws ActionRefused {
            throw unsupported("laws");
        }

        @Override
        public Change unloadLaw(String library) throws ActionRefused {
            throw unsupported("laws");
        }

        @Override
        public Change setLaw(String library, Map<String, Double> parameters) throws ActionRefused {
            throw unsupported("laws");
        }

        @Override
        public Reading laws(boolean faults) throws ActionRefused {
            throw unsupported("laws");
        }

        @Override
        public Map<String, Object> ledger(Optional<Boolean> open) throws ActionRefused {
            throw unsupported("laws");
        }

        @Override
        public Change picture() throws ActionRefused {
            throw unsupported("pictures");
        }

        @Override
        public Change changeRules(Map<String, Optional<String>> rules) throws ActionRefused {
            throw unsupported("rules");
        }

        @Override
        public Change release(String library) throws ActionRefused {
            throw unsupported("laws");
        }

        @Override
        public Object answer(String what, Map<String, Object> arguments) throws ActionRefused {
            throw unsupported(what);
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
