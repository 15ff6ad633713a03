// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import reve.core.frame.LawSwap;
import reve.core.frame.TimeBudget;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalLong;
import java.util.regex.Pattern;

/** A message from a client. {@code id} is {@link #NO_ID} if the client gave none. */
public sealed interface ClientMessage {

    /** Version of the protocol. */
    int PROTOCOL = 1;

    /** Value of {@link #id} for a message without an id. */
    long NO_ID = -1;

    /** Returns the id that the client gave, or {@link #NO_ID}. */
    long id();

    /** Returns the name of the message's type in the protocol. */
    default String type() {
        return switch (this) {
            case Hello hello -> "hello";
            case Perceive perceive -> "perceive";
            case Look look -> "look";
            case Act act -> "act";
            case Ready ready -> "ready";
            case Pause pause -> "pause";
            case Run run -> "run";
            case Step step -> "step";
            case LoadLaw load -> "load-law";
            case UnloadLaw unload -> "unload-law";
            case Edit edit -> "edit";
            case Add add -> "add";
            case Change change -> "change";
            case Remove remove -> "remove";
            case SetRule rule -> "rule";
            case Batch batch -> "batch";
            case Ask ask -> ask.what();
            case MoveWorld move -> "move-world";
            case DrainNode drain -> "drain-node";
            case AddWorld add -> "add-world";
            case Release release -> "release";
            case Picture picture -> "picture";
            case Snapshot snapshot -> "snapshot";
            case Rewind rewind -> "rewind";
            case Save save -> "save";
            case Fork fork -> "fork";
            case Speed speed -> "speed";
            case SetLaw set -> "set-law";
            case SetBudget set -> "set-budget";
            case State state -> "state";
            case Inspect inspect -> "inspect";
            case Laws laws -> "laws";
            case Perceived perceived -> "perceived";
            case Search search -> "search";
            case Ledger ledger -> "ledger";
            case Audit audit -> "audit";
            case ShutDown shutDown -> "shut-down";
            case Ping ping -> "ping";
            case Pong pong -> "pong";
            case Bye bye -> "bye";
        };
    }

    /**
     * The first message of a client, which opens or resumes its session, or asks a question.
     *
     * @param role name of the role, as received
     * @param world name of the world to join; needed only if the server has several
     * @param body name of the item that the client requests as its body
     * @param encoding name of the encoding of all later messages, as received
     * @param graceSeconds requested time that the body stays after the connection breaks [s]
     * @param lockStep empty unless the client runs in lock-step
     * @param resume the session to resume
     * @param token secret of the client's token
     * @param ask a question that the server answers instead of opening a session, as received
     */
    record Hello(
            long id,
            int protocol,
            String name,
            String role,
            Optional<String> world,
            Optional<String> body,
            String encoding,
            double graceSeconds,
            Optional<LockStep> lockStep,
            Optional<Resume> resume,
            Optional<String> token,
            Optional<String> ask)
            implements ClientMessage {

        /** The question for the nodes and worlds of the server's cluster. */
        public static final String CLUSTER = "cluster";

        private static final Pattern NAME = Pattern.compile("[A-Za-z0-9][A-Za-z0-9_.-]{0,63}");

        /** Returns whether the text is a valid client name. */
        public static boolean isName(String name) {
            return NAME.matcher(name).matches();
        }

        /** Returns the message as text, without secrets. */
        @Override
        public String toString() {
            return "hello of " + role + " " + name;
        }
    }

    /**
     * Settings of an agent in lock-step: the world waits for the agent.
     *
     * @param every number of frames between perceptions; after each perception the agent sends
     *     ready
     * @param relations whether perceptions contain spatial relations
     * @param deadlineSeconds maximum time that the world waits for the agent [s]
     * @param fallback the action that the agent's body performs if the agent is late
     */
    record LockStep(
            int every,
            boolean relations,
            double deadlineSeconds,
            Optional<ActionRequest> fallback) {}

    /**
     * Names the session that a client resumes after its connection broke.
     *
     * @param session the session token, from the welcome that the broken connection received
     * @param frame the last frame of which the client received all events
     */
    record Resume(String session, long frame) {}

    /**
     * Requests perceptions, as a stream or once.
     *
     * @param every number of frames between perceptions; 0 ends the stream, {@link #ONCE} requests
     *     one perception now
     * @param relations whether symbols contain relations (near, on, inside, touching)
     */
    record Perceive(long id, int every, boolean relations) implements ClientMessage {
        /** Requests one perception now. */
        public static final int ONCE = -1;
    }

    /**
     * Requests a picture.
     *
     * @param sensor name of a camera
     * @param item name of the body that carries the camera; if empty, the agent's own body
     */
    record Look(long id, String sensor, Optional<String> item) implements ClientMessage {}

    /**
     * Ends the current round of an agent in lock-step.
     *
     * @param frame frame of the perception that the agent has processed
     */
    record Ready(long id, OptionalLong frame) implements ClientMessage {}

    /** Requests a pong. */
    record Ping(long id) implements ClientMessage {}

    /** Answers a ping of the server. */
    record Pong(long id) implements ClientMessage {}

    /** Ends the session. */
    record Bye(long id) implements ClientMessage {}

    /**
     * A command. It has a result, and is executed at most once even if the client sends it again.
     */
    sealed interface Request extends ClientMessage {}

    /**
     * Requests an action.
     *
     * @param requested the requested action, which must name its item
     * @param ready if present, the act also ends the agent's round
     */
    record Act(long id, ActionRequest requested, Optional<Ready> ready) implements Request {}

    /** A command for the role control only. */
    sealed interface Control extends Request {}

    /** Pauses the world. */
    record Pause(long id) implements Control {}

    /** Resumes the world. */
    record Run(long id) implements Control {}

    /** Advances a paused world by some frames. */
    record Step(long id, int frames) implements Control {}

    /**
     * Loads a library of laws, or a law as text.
     *
     * @param library name of a library in the law folders of the server; for a text, its name in
     *     messages
     * @param text a law as text, which replaces the library
     * @param parameters the parameters of the library's laws, in SI units
     * @param swap how a text replaces a loaded one; if empty, the server chooses the way
     */
    record LoadLaw(
            long id,
            String library,
            Optional<String> text,
            Map<String, Double> parameters,
            Optional<LawSwap> swap)
            implements Control {}

    /** Unloads a library of laws. */
    record UnloadLaw(long id, String library) implements Control {}

    /**
     * Sets a property of an item.
     *
     * @param value Double, List of Double, String or Boolean
     */
    record Edit(long id, String item, String property, Object value) implements Control {}

    /** A command that changes the items or the rules of a world. */
    sealed interface WorldChange extends Control {}

    /**
     * Adds items.
     *
     * @param items a JSON object with {@code items} and {@code prefabs} in the form of a world file
     */
    record Add(long id, String items) implements WorldChange {}

    /**
     * Changes values of an item.
     *
     * @param to the new values of the item, in the form of a world file, as JSON; null removes a
     *     value
     */
    record Change(long id, String item, String to) implements WorldChange {}

    /**
     * Removes an item.
     *
     * @param cascade whether the items that refer to the item or are attached to it are removed,
     *     too
     */
    record Remove(long id, String item, boolean cascade) implements WorldChange {}

    /**
     * Adds, replaces or removes a rule.
     *
     * @param name the symbol that the rule computes
     * @param rule the rule in the form of a world file, as JSON; empty removes the rule
     */
    record SetRule(long id, String name, Optional<String> rule) implements WorldChange {}

    /** Several changes. Either all of them are made, or none. A batch contains no other batch. */
    record Batch(long id, List<WorldChange> changes) implements WorldChange {
        /** Maximum number of changes. */
        public static final int MAX = 1000;

        /** Copies the list. */
        public Batch {
            changes = List.copyOf(changes);
        }
    }

    /**
     * A question about the world; its result contains the answer as a value.
     *
     * @param what one of {@link #QUESTIONS}
     * @param arguments Double, List of Double, String or Boolean by name
     */
    record Ask(long id, String what, Map<String, Object> arguments) implements Control {
        /**
         * The possible questions, with the names of their arguments; a * marks optional arguments.
         */
        public static final Map<String, List<String>> QUESTIONS =
                Map.of(
                        "profile", List.of(),
                        "changes", List.of(),
                        "cluster", List.of(),
                        "near", List.of("location", "distance*", "most*"),
                        "region", List.of("from", "to"));

        /** Copies the arguments. */
        public Ask {
            arguments = Collections.unmodifiableMap(new LinkedHashMap<>(arguments));
        }
    }

    /** An order to the cluster of the server. It may concern other worlds than the client's. */
    sealed interface Order extends Control {}

    /**
     * Moves a world to a node.
     *
     * @param world name of the world that moves
     * @param node address of the node that shall run it, or {@link
     *     reve.core.agent.port.ClusterPort#ANY}
     */
    record MoveWorld(long id, String world, String node) implements Order {}

    /**
     * Moves all worlds of a node away, or ends this order.
     *
     * @param node address of the node
     * @param drained true if the node shall run no worlds, false if it may run worlds again
     */
    record DrainNode(long id, String node, boolean drained) implements Order {}

    /**
     * Adds a world to the cluster.
     *
     * @param text a world file that refers to no other files
     * @param asleep true if the world makes its first frame only when a client asks for it
     */
    record AddWorld(long id, String text, boolean asleep) implements Order {}

    /**
     * Ends the quarantine of a library of laws. The library failed, and the world has run without
     * it since then.
     */
    record Release(long id, String library) implements Control {}

    /** Requests a picture of the world. */
    record Picture(long id) implements Control {}

    /**
     * Saves the state of the world in memory.
     *
     * @param image name under which the state of the world is saved in memory
     */
    record Snapshot(long id, String image) implements Control {}

    /**
     * Rewinds the world to a saved state.
     *
     * @param image name of a saved state; if empty, the state at the start of the world
     */
    record Rewind(long id, Optional<String> image) implements Control {}

    /**
     * Writes the world to a file.
     *
     * @param file name of the world file to write
     */
    record Save(long id, String file) implements Control {}

    /**
     * Advances a copy of the world and reports its state.
     *
     * @param frames number of frames by which a copy of the world advances
     * @param changes changes that are made in the copy before it advances
     */
    record Fork(long id, int frames, Optional<Batch> changes) implements Control {}

    /** Ends the world. */
    record ShutDown(long id) implements Control {}

    /**
     * Changes the speed of the world.
     *
     * @param factor simulated time divided by elapsed time
     */
    record Speed(long id, double factor) implements Control {}

    /**
     * Changes parameters of a loaded library of laws.
     *
     * @param parameters new values of parameters of a loaded library, in SI units; other parameters
     *     keep their values
     * @param swap how the values take effect; if empty, at once
     */
    record SetLaw(long id, String library, Map<String, Double> parameters, Optional<LawSwap> swap)
            implements Control {}

    /**
     * Limits the computing time of a library of laws.
     *
     * @param budget the limit on the computing time of a loaded library in a frame; empty to remove
     *     the limit
     */
    record SetBudget(long id, String library, Optional<TimeBudget> budget) implements Control {}

    /** Requests the ledger of energy and momentum; {@code open} opens or closes it. */
    record Ledger(long id, Optional<Boolean> open) implements Control {}

    /**
     * Requests the newest records of the audit log about the world.
     *
     * @param client name of the client whose records are requested; empty for all clients
     * @param frequent whether records of frequent messages, such as perceptions, are requested, too
     * @param most maximum number of records, 1 to {@link #MAX}
     */
    record Audit(long id, Optional<String> client, boolean frequent, int most) implements Control {
        /** Maximum number of records in a report. */
        public static final int MAX = 200;

        /** Number of records in a report if the request contains no number. */
        public static final int DEFAULT = 50;
    }

    /**
     * A request for a report about the world. Only clients that perceive everything may send it. It
     * changes nothing.
     */
    sealed interface Query extends Request {}

    /**
     * Requests the state of the world's frame loop and of its clients.
     *
     * @param roundTrips whether the server measures the round-trip times of the clients for later
     *     reports
     */
    record State(long id, boolean roundTrips) implements Query {}

    /** Requests a report of the aspects of an item. */
    record Inspect(long id, String item) implements Query {}

    /** Requests the loaded, quarantined and available laws. */
    record Laws(long id) implements Query {}

    /**
     * Requests the items that an agent perceived last.
     *
     * @param client name of the agent
     */
    record Perceived(long id, String client) implements Query {}

    /**
     * Requests the items whose names or symbols contain a text.
     *
     * @param text the text, in letters of any case
     */
    record Search(long id, String text) implements Query {}
}
