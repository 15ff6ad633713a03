// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import reve.core.agent.audit.AuditLog;
import reve.core.agent.auth.AgentToken;
import reve.core.agent.auth.Attempts;
import reve.core.agent.auth.Rights;
import reve.core.agent.auth.TokenFile;
import reve.core.agent.net.Connection;
import reve.core.agent.net.Door;
import reve.core.agent.port.ClusterPort;
import reve.core.agent.port.Elsewhere;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.Role;
import reve.core.agent.protocol.ServerMessage;
import reve.core.agent.protocol.Text;

import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.TreeMap;
import java.util.stream.Collectors;
import java.util.stream.Stream;

/**
 * Decides by a client's hello whether the client is admitted, and to which world. For the event
 * loop's thread only.
 */
public final class Admission implements Door {

    private final List<ServedWorld> worlds;
    private final int maxClients;
    private final Optional<TokenFile> tokens;
    private final Optional<AuditLog> audit;
    private final Attempts attempts = new Attempts();
    private volatile Elsewhere elsewhere = Elsewhere.NOWHERE;

    /**
     * @param maxClients maximum number of clients of all worlds, including disconnected ones
     * @param tokens valid tokens; if empty, clients need none
     * @param audit the audit record, if messages must not be sent without it
     */
    public Admission(
            List<ServedWorld> worlds,
            int maxClients,
            Optional<TokenFile> tokens,
            Optional<AuditLog> audit) {
        this.worlds = worlds;
        this.maxClients = maxClients;
        this.tokens = tokens;
        this.audit = audit;
    }

    @Override
    public Optional<ServerMessage> answer(Connection connection, ClientMessage.Hello hello)
            throws CloseReason {
        if (hello.ask().isEmpty()) {
            return Optional.empty();
        }
        String what = hello.ask().get();
        Role role = requireAcceptable(hello);
        Optional<AgentToken> token = requireToken(connection, hello);
        requireRecord();
        requireOpen(hello, role, token);
        if (role != Role.CONTROL || !what.equals(ClientMessage.Hello.CLUSTER)) {
            throw CloseReason.refused(
                    "bad-question",
                    "a hello of the role " + role.wireName() + " asks " + Text.quote(what),
                    "expected \"role\":\"control\" and \"ask\":\"cluster\", or no question");
        }
        var question = new ClientMessage.Ask(hello.id(), what, Map.of());
        Optional<String> refusal = token.flatMap(known -> known.rights().refusal(question));
        if (refusal.isPresent()) {
            throw CloseReason.refused(
                    "not-permitted",
                    "your token does not permit this: " + refusal.get(),
                    "ask whoever runs the server for one that does");
        }
        if (!elsewhere.isComplete()) {
            throw starting(Optional.empty());
        }
        ClusterPort cluster =
                elsewhere
                        .cluster()
                        .orElseThrow(
                                () ->
                                        CloseReason.refused(
                                                "unsupported",
                                                "this server belongs to no cluster",
                                                "join a world, and ask for its state"));
        return Optional.of(new ServerMessage.Answer(hello.id(), 0, cluster.state()));
    }

    @Override
    public Session greet(Connection connection, ClientMessage.Hello hello) throws CloseReason {
        Role role = requireAcceptable(hello);
        if (hello.resume().isPresent()) {
            return resume(connection, hello, hello.resume().get());
        }
        Optional<AgentToken> token = requireToken(connection, hello);
        requireRecord();
        ServedWorld world = requireWorld(connection, hello, role, token);
        requireOpen(hello, role, token);
        int clients = worlds.stream().mapToInt(ServedWorld::clients).sum();
        if (clients >= maxClients) {
            // The number includes sessions that wait for a new connection.
            throw CloseReason.serverFull(maxClients);
        }
        return world.greet(connection, role, hello, token);
    }

    private void requireRecord() throws CloseReason {
        if (audit.isPresent() && !audit.get().isServing()) {
            throw CloseReason.notRecorded();
        }
    }

    private Session resume(
            Connection connection, ClientMessage.Hello hello, ClientMessage.Resume resume)
            throws CloseReason {
        Optional<Session> found =
                meant(hello.world()).stream()
                        .flatMap(world -> world.find(hello.name()).stream())
                        .filter(session -> session.hasSecret(resume.session()))
                        .findFirst();
        if (found.isEmpty()) {
            sendOn(connection, hello);
            countWrong(connection);
            throw CloseReason.refused(
                    "no-such-session",
                    "there is no session of "
                            + Text.quote(hello.name())
                            + " with this token, or it has ended",
                    "say hello without resume");
        }
        requireRecord();
        found.get().resume(connection, resume.frame());
        return found.get();
    }

    /**
     * Sends a client that resumes a session on to the server that has its world, if this server
     * does not have it.
     */
    private void sendOn(Connection connection, ClientMessage.Hello hello) throws CloseReason {
        Role role = requireAcceptable(hello);
        boolean isHere = !meant(hello.world()).isEmpty() && hasSessions(role);
        boolean isElsewhere =
                hello.world().isPresent()
                        && !isHere
                        && (elsewhere.worlds().containsKey(hello.world().get())
                                || !elsewhere.isComplete());
        if (isElsewhere) {
            requireWorld(connection, hello, role, requireToken(connection, hello));
        }
    }

    /**
     * Sets the source of the worlds that other servers have. A client that asks for such a world is
     * referred to its server. For any thread.
     */
    public void sendTo(Elsewhere others) {
        elsewhere = others;
    }

    /**
     * Returns the world that the hello names. Returns the only world that the client may join if
     * the hello names no world.
     */
    private ServedWorld requireWorld(
            Connection connection, ClientMessage.Hello hello, Role role, Optional<AgentToken> token)
            throws CloseReason {
        Optional<String> name = hello.world();
        Rights rights = token.map(AgentToken::rights).orElse(Rights.ALL);
        Map<String, ServedWorld> here = new TreeMap<>();
        if (hasSessions(role)) {
            meant(Optional.empty()).stream()
                    .filter(world -> rights.opensWorld(world.name()))
                    .forEach(world -> here.put(world.name(), world));
        }
        Map<String, String> there = new TreeMap<>(elsewhere.worlds());
        there.keySet().removeIf(world -> here.containsKey(world) || !rights.opensWorld(world));
        List<String> open =
                Stream.concat(here.keySet().stream(), there.keySet().stream()).sorted().toList();
        if (name.map(wanted -> !rights.opensWorld(wanted))
                .orElse(open.isEmpty() && elsewhere.isComplete())) {
            throw CloseReason.refused( // the refusal must not reveal which worlds exist
                    "not-permitted",
                    name.map(wanted -> "your token does not open the world " + Text.quote(wanted))
                            .orElse("your token opens no world of this server"),
                    "ask whoever runs the server for one that does");
        }
        List<String> meant = open.stream().filter(each -> name.orElse(each).equals(each)).toList();
        if (!elsewhere.isComplete() && (name.isEmpty() || meant.isEmpty())) {
            throw starting(name);
        }
        if (meant.size() == 1) {
            String world = meant.getFirst();
            ServedWorld served = here.get(world);
            String address = there.getOrDefault(world, "");
            boolean runs = served != null || !address.isEmpty();
            if (role == Role.OBSERVER && !connection.isRelayed() && runs) {
                Optional<String> watching = elsewhere.forObserver(world, hello.name());
                if (watching.isPresent()) {
                    throw CloseReason.moved(world, watching.get());
                }
            }
            if (served != null) {
                return served;
            }
            requireOpen(hello, role, token); // others must not start a world
            if (address.isEmpty()) {
                elsewhere.wanted(world);
                throw starting(Optional.of(world));
            }
            if (elsewhere.isWatching() && role == Role.OBSERVER) {
                Optional<String> problem = elsewhere.watched(world);
                if (problem.isPresent()) {
                    throw CloseReason.refused(
                            "unsupported",
                            "this server cannot show the world " + Text.quote(world),
                            problem.get());
                }
                throw starting(Optional.of(world));
            }
            throw CloseReason.moved(world, address);
        }
        String problem =
                name.map(unknown -> "this server has no world " + Text.quote(unknown))
                        .orElse("this server has " + open.size() + " worlds");
        String names = open.stream().map(Text::quote).collect(Collectors.joining(" or "));
        throw CloseReason.refused("no-such-world", problem, "say hello with \"world\": " + names);
    }

    /** Returns whether clients of a role join the worlds of this server, not only observers. */
    private boolean hasSessions(Role role) {
        return role == Role.OBSERVER || !elsewhere.isWatching();
    }

    private static CloseReason starting(Optional<String> world) {
        return CloseReason.refused(
                "world-starting",
                world.map(name -> "no server is ready to serve the world " + Text.quote(name))
                                .orElse("this server does not know its worlds")
                        + " now",
                "try again in a second");
    }

    /**
     * Returns the world with the given name, or all worlds if the name is empty. Worlds that have
     * ended are omitted.
     */
    private List<ServedWorld> meant(Optional<String> name) {
        return worlds.stream()
                .filter(world -> !world.hasEnded())
                .filter(world -> name.isEmpty() || name.get().equals(world.name()))
                .toList();
    }

    /** Returns the client's token; empty if the server uses no tokens. */
    private Optional<AgentToken> requireToken(Connection connection, ClientMessage.Hello hello)
            throws CloseReason {
        if (tokens.isEmpty()) {
            return Optional.empty();
        }
        Optional<AgentToken> token = tokens.get().find(hello.token().orElse(""));
        if (token.isEmpty()) {
            countWrong(connection);
            throw CloseReason.refused(
                    "bad-token",
                    "this server takes a token, and there was none or a wrong one",
                    "say hello with the \"token\" that whoever runs the server gave you");
        }
        return token;
    }

    /**
     * Counts a wrong secret for the network address; throws if there are too many. Right secrets
     * are not counted.
     */
    private void countWrong(Connection connection) throws CloseReason {
        if (!attempts.take(connection.address(), System.nanoTime())) {
            throw CloseReason.cut(
                    "too-many-attempts",
                    "too many wrong tokens came from your address; try again later");
        }
    }

    private static void requireOpen(
            ClientMessage.Hello hello, Role role, Optional<AgentToken> token) throws CloseReason {
        Rights rights = token.map(AgentToken::rights).orElse(Rights.ALL);
        if (token.isPresent() && !token.get().name().equals(hello.name())) {
            throw CloseReason.refused(
                    "not-permitted",
                    "your token is for another name than " + Text.quote(hello.name()),
                    "say hello with the name that it was made for");
        }
        if (!rights.roles().contains(role)) {
            throw CloseReason.refused(
                    "not-permitted",
                    "your token does not open the role " + role.wireName(),
                    "it opens " + rights.roles().stream().map(Role::wireName).sorted().toList());
        }
        if (hello.lockStep().isPresent() && !rights.lockStep()) {
            throw CloseReason.refused(
                    "not-permitted",
                    "your token does not let the world wait for you",
                    "leave out time, or ask for a token with lock-step");
        }
    }

    private static Role requireAcceptable(ClientMessage.Hello hello) throws CloseReason {
        if (hello.protocol() != ClientMessage.PROTOCOL) {
            throw CloseReason.refused(
                    "protocol-unsupported",
                    "this server does not speak protocol " + hello.protocol(),
                    "say hello with \"protocol\":" + ClientMessage.PROTOCOL);
        }
        if (!ClientMessage.Hello.isName(hello.name())) {
            throw CloseReason.refused(
                    "bad-name",
                    Text.quote(hello.name()) + " is no name for an agent",
                    "use 1 to 64 of A-Z a-z 0-9 _ . - and begin with a letter or digit");
        }
        return Role.of(hello.role())
                .orElseThrow(
                        () ->
                                CloseReason.refused(
                                        "role-unsupported",
                                        "this server does not know the role "
                                                + Text.quote(hello.role()),
                                        "expected " + Role.names()));
    }
}
