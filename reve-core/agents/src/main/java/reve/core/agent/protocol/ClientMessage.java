// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalLong;
import java.util.regex.Pattern;

/** What a client says. {@code id} is {@link #NO_ID} where it gave none. */
public sealed interface ClientMessage {

    /** The protocol version that the server speaks. */
    int PROTOCOL = 1;

    /** The id of a message that has none. */
    long NO_ID = -1;

    /** Returns the id that the client gave, or {@link #NO_ID}. */
    long id();

    /** The message as the protocol names it. */
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
            case Picture picture -> "picture";
            case Snapshot snapshot -> "snapshot";
            case Rewind rewind -> "rewind";
            case Save save -> "save";
            case Fork fork -> "fork";
            case ShutDown shutDown -> "shut-down";
            case Ping ping -> "ping";
            case Pong pong -> "pong";
            case Bye bye -> "bye";
        };
    }

    /**
     * @param role as written
     * @param world that it wants to come to; needed only where there are several
     * @param body the lent item it asks for
     * @param encoding of all that follows, as written
     * @param graceSeconds how long its body is to stay when the connection breaks
     * @param lockStep empty for an agent that nobody waits for
     * @param resume the session it goes on with
     * @param token the secret that opens the server for it
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
            Optional<String> token)
            implements ClientMessage {

        private static final Pattern NAME = Pattern.compile("[A-Za-z0-9][A-Za-z0-9_.-]{0,63}");

        /** Returns whether a client may have that name. */
        public static boolean isName(String name) {
            return NAME.matcher(name).matches();
        }

        /** Without its secrets. */
        @Override
        public String toString() {
            return "hello of " + role + " " + name;
        }
    }

    /**
     * The world is to wait for the agent.
     *
     * @param every frames between perceptions, after each of which the agent says that it is ready
     * @param relations of the perceptions
     * @param deadlineSeconds longest wait
     * @param fallback what its body does when it is late
     */
    record LockStep(
            int every, boolean relations, double deadlineSeconds, Optional<Fallback> fallback) {}

    /**
     * What an agent's body does when the agent is late.
     *
     * @param item whose action; empty for the body's own
     * @param arguments Double, List of Double, String or Boolean by parameter name
     */
    record Fallback(Optional<String> item, String action, Map<String, Object> arguments) {
        /** Copies the arguments. */
        public Fallback {
            arguments = Collections.unmodifiableMap(new LinkedHashMap<>(arguments));
        }
    }

    /**
     * @param session what the welcome of the broken connection gave
     * @param frame the last one whose events have all come
     */
    record Resume(String session, long frame) {}

    /**
     * @param every frames between perceptions; 0 for no more, {@link #ONCE} for one now
     * @param relations whether symbols hold what is near, on, inside and touching, too
     */
    record Perceive(long id, int every, boolean relations) implements ClientMessage {
        /** One perception, now. */
        public static final int ONCE = -1;
    }

    /**
     * @param sensor one of its body's cameras
     */
    record Look(long id, String sensor) implements ClientMessage {}

    /**
     * The agent has done what it does in this round.
     *
     * @param frame of the perception that it has seen
     */
    record Ready(long id, OptionalLong frame) implements ClientMessage {}

    /** Asks whether the server is there. */
    record Ping(long id) implements ClientMessage {}

    /** Answers a ping of the server. */
    record Pong(long id) implements ClientMessage {}

    /** Ends the session. */
    record Bye(long id) implements ClientMessage {}

    /** What has a result and is done at most once. */
    sealed interface Request extends ClientMessage {}

    /**
     * @param arguments Double, List of Double, String or Boolean by parameter name
     * @param ready if it is all that the agent does in this round
     */
    record Act(
            long id,
            String item,
            String action,
            Map<String, Object> arguments,
            Optional<Ready> ready)
            implements Request {}

    /** What only the role control may say. */
    sealed interface Control extends Request {}

    /** Stops the world. */
    record Pause(long id) implements Control {}

    /** Lets the world go on. */
    record Run(long id) implements Control {}

    /** Lets the world make some frames. */
    record Step(long id, int frames) implements Control {}

    /**
     * @param parameters of its laws, in SI units
     */
    record LoadLaw(long id, String library, Map<String, Double> parameters) implements Control {}

    /** Removes the laws of a library. */
    record UnloadLaw(long id, String library) implements Control {}

    /**
     * @param value Double, List of Double, String or Boolean
     */
    record Edit(long id, String item, String property, Object value) implements Control {}

    /** Has a picture of the world drawn. */
    record Picture(long id) implements Control {}

    /**
     * @param image the name under which the world is kept as it is now
     */
    record Snapshot(long id, String image) implements Control {}

    /**
     * @param image the name under which the world was kept; without, its beginning
     */
    record Rewind(long id, Optional<String> image) implements Control {}

    /**
     * @param file name of the world file
     */
    record Save(long id, String file) implements Control {}

    /**
     * @param frames that a copy of the world is to make
     */
    record Fork(long id, int frames) implements Control {}

    /** Ends the world. */
    record ShutDown(long id) implements Control {}
}
