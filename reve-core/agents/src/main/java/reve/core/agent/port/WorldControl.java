// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

import reve.core.frame.LawSwap;
import reve.core.frame.TimeBudget;
import reve.core.world.ActionRefused;
import reve.core.world.ItemId;
import reve.core.world.World;
import reve.core.world.WorldSnapshot;

import java.util.Collection;
import java.util.Map;
import java.util.Optional;
import java.util.function.Consumer;

/**
 * The commands of clients with the role control that a frame loop cannot execute itself. The
 * program that runs the world implements this interface to execute them. Methods are called on a
 * connection's thread and may block, unless stated otherwise. A returned change is made on the
 * world's thread, in the phase ACT of a frame.
 */
public interface WorldControl {

    /** A prepared change of a world. */
    @FunctionalInterface
    interface Change {
        /**
         * Makes the change in the world.
         *
         * @throws ActionRefused with a code and a reason if it is not possible; the world is then
         *     unchanged
         */
        void make(World world, long frame) throws ActionRefused;

        /**
         * Returns the name that the library loaded by this change gives itself; empty if the change
         * loads no library.
         */
        default Optional<String> library() {
            return Optional.empty();
        }

        /**
         * Returns the field {@code value} of the result; empty if the result has none. Called after
         * {@link #make}.
         */
        default Optional<Object> value() {
            return Optional.empty();
        }

        /** Called instead of {@link #make} if the change is never made. */
        default void drop() {}
    }

    /**
     * Prepares loading a library of laws. It replaces a loaded library of the same name if the
     * content of its file has changed.
     *
     * @param library name without a folder; the program searches its law folders
     * @param parameters the parameters of the library's laws, by {@code parameter} or {@code
     *     law.parameter}, in SI units
     * @param swap how the library replaces a loaded one; if empty, the program chooses the way
     */
    Change loadLaw(String library, Map<String, Double> parameters, Optional<LawSwap> swap)
            throws ActionRefused;

    /**
     * Prepares loading a law as text. It replaces a loaded text of the same name.
     *
     * @param source name of the text in messages, such as "wind.law"
     * @param parameters the parameters of the text's laws, by {@code parameter} or {@code
     *     law.parameter}, in SI units
     * @param swap how the text replaces a loaded one; if empty, the program chooses the way
     * @throws ActionRefused with all problems of the text and their lines
     */
    Change loadText(
            String source, String text, Map<String, Double> parameters, Optional<LawSwap> swap)
            throws ActionRefused;

    /** Prepares unloading a library of laws by its name. */
    Change unloadLaw(String library) throws ActionRefused;

    /**
     * Prepares a change of the parameters of a loaded library, which keeps its place in the order
     * of laws.
     *
     * @param parameters new values, named like in {@link #loadLaw}; other parameters keep their
     *     values
     * @param swap how the values take effect; if empty, at once
     */
    Change setLaw(String library, Map<String, Double> parameters, Optional<LawSwap> swap)
            throws ActionRefused;

    /**
     * Prepares a budget for the computing time of a loaded library.
     *
     * @param budget empty to remove the budget
     */
    Change setBudget(String library, Optional<TimeBudget> budget) throws ActionRefused;

    /** A prepared report about a world. */
    @FunctionalInterface
    interface Reading {
        /** Reads the world. For the world's thread, between frames. */
        Map<String, Object> read() throws ActionRefused;
    }

    /**
     * Prepares a report of the loaded, quarantined and available laws.
     *
     * @param faults whether to include messages of faults, which may name files of the server
     */
    Reading laws(boolean faults) throws ActionRefused;

    /**
     * Returns the fields that the report of an item has for the columns that laws have of their
     * own: {@code lawColumns} and {@code moreLawColumns}, see agents/protocol/PROTOCOL.md; empty if
     * there are none. For the world's thread, between frames.
     *
     * @param item name of the item, which need not exist
     */
    default Map<String, Object> lawColumns(String item) {
        return Map.of();
    }

    /**
     * Opens or closes the ledger, then returns a report of it. The ledger shows the energy and
     * momentum that each law adds. For the world's thread, between frames.
     *
     * @param open true opens or restarts the ledger, false closes it, empty leaves it as it is
     */
    Map<String, Object> ledger(Optional<Boolean> open) throws ActionRefused;

    /**
     * Prepares a picture of the frame that is being made. The value of the result names its file.
     */
    Change picture() throws ActionRefused;

    /**
     * Prepares changes of rules, all of them or none.
     *
     * @param rules the rules in the form of a world file, in JSON, by the symbol that each rule
     *     computes; an empty value removes the rule
     */
    Change changeRules(Map<String, Optional<String>> rules) throws ActionRefused;

    /** Returns the cluster to which the server of the world belongs; empty if there is none. */
    default Optional<ClusterPort> cluster() {
        return Optional.empty();
    }

    /** Prepares the end of the quarantine of a library that failed. */
    Change release(String library) throws ActionRefused;

    /**
     * Answers a question about the world. For the world's thread, between frames.
     *
     * @param what the type of the message in the protocol, such as {@code near}
     * @param arguments Double, List of Double, String or Boolean by name
     * @return a List or Map with values of type String, Boolean or Number, or with lists and maps
     *     of such values; keys are texts
     */
    Object answer(String what, Map<String, Object> arguments) throws ActionRefused;

    /** A saved state of the world, to which it can be rewound. */
    interface Image extends AutoCloseable {
        /**
         * Rewinds the world to this state. For the world's thread, between frames.
         *
         * @return number of the next frame, which shows the restored state
         */
        long rewind();

        /**
         * Writes the state as a world file into the program's folder. For any thread.
         *
         * @param file name without a folder
         * @param without ids of items that the file omits; it also omits the items attached to them
         */
        void save(String file, Collection<ItemId> without) throws ActionRefused;

        /**
         * Advances a copy of the world. The copy receives no commands, and the world itself is not
         * affected. For any thread.
         *
         * @param frames number of frames to make in the copy
         * @param first the change that is made in the copy before its first frame
         * @param look receives a snapshot of the last frame of the copy
         */
        void foresee(int frames, Change first, Consumer<WorldSnapshot> look) throws ActionRefused;

        @Override
        void close();
    }

    /** Returns the state of the world at its start. The program closes it. */
    Image beginning() throws ActionRefused;

    /**
     * Returns the present state of the world. For the world's thread, between frames. The caller
     * closes the image.
     */
    Image keep() throws ActionRefused;

    /** Returns an implementation for a program without laws, pictures or images. */
    static WorldControl none() {
        return new NoControl("this server has none for this world");
    }

    /**
     * Returns an implementation that refuses every command.
     *
     * @param reason the reason, for the client
     */
    static WorldControl none(String reason) {
        return new NoControl(reason);
    }

    /** An implementation that refuses every command. */
    final class NoControl implements WorldControl {
        private final String reason;

        private NoControl(String reason) {
            this.reason = reason;
        }

        @Override
        public Change loadLaw(
                String library, Map<String, Double> parameters, Optional<LawSwap> swap)
                throws ActionRefused {
            throw unsupported("laws");
        }

        @Override
        public Change loadText(
                String source, String text, Map<String, Double> parameters, Optional<LawSwap> swap)
                throws ActionRefused {
            throw unsupported("laws");
        }

        @Override
        public Change unloadLaw(String library) throws ActionRefused {
            throw unsupported("laws");
        }

        @Override
        public Change setLaw(String library, Map<String, Double> parameters, Optional<LawSwap> swap)
                throws ActionRefused {
            throw unsupported("laws");
        }

        @Override
        public Change setBudget(String library, Optional<TimeBudget> budget) throws ActionRefused {
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

        private ActionRefused unsupported(String what) {
            return new ActionRefused("unsupported", what + ": " + reason);
        }
    }
}
