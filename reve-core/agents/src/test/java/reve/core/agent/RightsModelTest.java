// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.Seed;
import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.access.Terms;
import reve.core.agent.auth.AgentSecurity;
import reve.core.agent.auth.AgentToken;
import reve.core.agent.auth.Rights;
import reve.core.agent.auth.TokenFile;
import reve.core.agent.protocol.Role;
import reve.core.file.AgentPolicy;
import reve.core.unit.Unit;
import reve.core.world.ItemDefinition;
import reve.core.world.Parameter;
import reve.core.world.Sensor;
import reve.core.world.Shape;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.net.Socket;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.EnumSet;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.Set;
import java.util.TreeMap;
import java.util.TreeSet;

/**
 * Random operations of clients with all kinds of tokens, compared with a small model of their
 * rights: every answer, perception and effect must agree.
 */
class RightsModelTest {

    /** Number of operations. A long run uses a million. */
    private static final int OPERATIONS = Integer.getInteger("reve.abuse.operations", 4_000);

    private static final Parameter IMPULSE =
            Parameter.number("impulse", 3, Unit.parse("N*s"), "How hard.");
    private static final Parameter OTHER = Parameter.item("other", "Which.");
    private static final List<String> CAPABILITIES = List.of("lift", "push", "fly");
    private static final List<String> LENT = List.of("boat", "raft", "kite");
    private static final double NEAR = 10;
    private static final int MAX_ERRORS = 6;

    /**
     * @param needs capabilities by action; every action pushes its item by 1 N s
     */
    private record Thing(
            String name,
            double x,
            Set<String> capabilities,
            boolean sensing,
            boolean sensesActions,
            Map<String, List<String>> needs) {

        ItemDefinition definition() {
            ItemDefinition.Builder item =
                    ItemDefinition.named(name)
                            .shape(Shape.sphere(0.25))
                            .at(x, 0, 0)
                            .physics("mass", 1)
                            .physics("velocity", 0, 0, 0);
            capabilities.forEach(item::capability);
            if (sensing) {
                Sensor eyes = Sensor.sight("eyes", NEAR);
                item.sensor(
                        sensesActions
                                ? eyes
                                : new Sensor(
                                        "eyes",
                                        false,
                                        NEAR,
                                        Sensor.ALL_ROUND,
                                        false,
                                        1,
                                        Optional.empty(),
                                        EnumSet.of(Sensor.Aspect.PHYSICAL, Sensor.Aspect.SEMANTIC),
                                        Optional.empty(),
                                        Optional.empty()));
            }
            needs.forEach(
                    (action, capable) ->
                            item.action(
                                    new DeclaredAction(
                                            action,
                                            "Pushes it.",
                                            action.equals("throw")
                                                    ? List.of(IMPULSE, OTHER)
                                                    : List.of(IMPULSE),
                                            new Terms(capable, List.of()),
                                            List.of(
                                                    new Effect.Impulse(
                                                            new Operand.Argument(IMPULSE))))));
            return item.build();
        }
    }

    private static final Map<String, List<String>> NO_NEEDS = Map.of("push", List.of());
    private static final List<Thing> THINGS =
            List.of(
                    new Thing("boat", 0, Set.of("lift", "push"), true, true, NO_NEEDS),
                    new Thing("raft", 1, Set.of("push"), true, false, NO_NEEDS),
                    new Thing("kite", 2, Set.of("fly", "lift"), false, true, NO_NEEDS),
                    new Thing(
                            "duck",
                            5,
                            Set.of(),
                            false,
                            true,
                            Map.of("push", List.of(), "throw", List.of())),
                    new Thing(
                            "crate",
                            6,
                            Set.of(),
                            false,
                            true,
                            Map.of("push", List.of("lift"), "throw", List.of("push"))),
                    new Thing(
                            "gem",
                            7,
                            Set.of(),
                            false,
                            true,
                            Map.of("push", List.of("lift", "fly"))),
                    new Thing(
                            "star",
                            500,
                            Set.of(),
                            false,
                            true,
                            Map.of("push", List.of(), "throw", List.of("fly"))));
    private static final Map<String, Thing> BY_NAME = new HashMap<>();
    private static final List<String> ITEMS = new ArrayList<>(List.of("nothing"));
    private static final List<String> ACTIONS = List.of("push", "throw", "explode");

    static {
        for (Thing thing : THINGS) {
            BY_NAME.put(thing.name, thing);
            ITEMS.add(thing.name);
        }
    }

    private record Holder(String name, String secret, Rights rights) {}

    /** A client in the model. A client without a body is no agent. */
    private final class Client {
        private final Holder holder;
        private final Role role;
        private final TestClient connection;
        private Optional<Thing> body = Optional.empty();
        private int errors;
        private long lastId;
        private final Map<Long, String> answered = new LinkedHashMap<>();

        Client(Holder holder, Role role, TestClient connection) {
            this.holder = holder;
            this.role = role;
            this.connection = connection;
        }

        boolean senses(Thing thing) {
            return body.isEmpty()
                    || !body.get().sensing
                    || Math.abs(body.get().x - thing.x) <= NEAR;
        }

        /**
         * Returns the expected result of an act: a code, or an empty text if the act is executed.
         */
        String verdict(String item, String action, String other) {
            Thing thing = BY_NAME.get(item);
            if (thing == null || !senses(thing)) {
                return "no-such-item";
            }
            Thing own = body.orElseThrow();
            boolean blind = own.sensing && !own.sensesActions && !item.equals(own.name);
            if (blind || !thing.needs.containsKey(action)) {
                return "no-such-action";
            }
            if (action.equals("throw")
                    && own.sensing
                    && (!BY_NAME.containsKey(other) || !senses(BY_NAME.get(other)))) {
                return "no-such-item";
            }
            for (String need : thing.needs.get(action)) {
                if (!own.capabilities.contains(need)
                        || !opens(holder.rights.capabilities(), need)) {
                    return "not-capable";
                }
            }
            return "";
        }
    }

    private static boolean opens(Optional<Set<String>> names, String name) {
        return names.isEmpty() || names.get().contains(name);
    }

    private final Map<String, Client> clients = new TreeMap<>();
    private final Map<String, Double> pushes = new HashMap<>();
    private final List<Holder> holders = new ArrayList<>();
    private final Map<String, Integer> seen = new TreeMap<>();
    private long wrongTokens;
    private long operations;

    private AgentRoom room;
    private Random random;

    @TempDir private Path folder;

    @Test
    void everyAnswerIsAsTheRightsSay() throws IOException {
        long seed = Seed.of("the rights");
        random = new Random(seed);
        Path file = issueTokens();
        AgentServerConfig config =
                AgentServerConfig.on(
                        AgentRoom.CONFIG.address(),
                        new AgentSecurity(Optional.of(TokenFile.open(file)), Optional.empty()));
        try (AgentRoom open =
                new AgentRoom(
                        config,
                        new AgentPolicy(LENT, Optional.empty()),
                        4096,
                        THINGS.stream().map(Thing::definition).toList())) {
            room = open;
            while (operations < OPERATIONS) {
                comeOrGo();
                act();
            }
            for (Thing thing : THINGS) {
                assertThat(room.item(thing.name).physics().vector("velocity")[0])
                        .as("pushes of %s", thing.name)
                        .isEqualTo(pushes.getOrDefault(thing.name, 0.0));
            }
            for (Client client : List.copyOf(clients.values())) {
                leave(client);
            }
        }
        System.out.println(operations + " operations: " + seen);
        assertThat(seen.keySet())
                .contains(
                        "done",
                        "bad-token",
                        "not-permitted",
                        "no-such-item",
                        "no-such-action",
                        "not-capable",
                        "again",
                        "perceived");
    }

    private Path issueTokens() throws IOException {
        Path file = folder.resolve("tokens.json");
        for (int i = 0; i < 12; i++) {
            Rights rights =
                    new Rights(
                            some(List.of(Role.values()), 0.5).orElse(Set.of(Role.AGENT)),
                            i % 4 == 3 ? Optional.of(Set.of("sea")) : some(List.of("pond"), 1),
                            i % 2 == 0 ? Optional.empty() : some(LENT, 0.6),
                            some(CAPABILITIES, 0.6),
                            false);
            AgentToken.Issued issued = AgentToken.issue("agent" + i % 8, rights, Optional.empty());
            TokenFile.add(file, issued.token());
            holders.add(new Holder(issued.token().name(), issued.secret(), rights));
        }
        return file;
    }

    /** Returns a random subset that is not empty, or empty for no limit. */
    private <T> Optional<Set<T>> some(List<T> all, double share) {
        Set<T> chosen = new HashSet<>();
        all.stream().filter(one -> random.nextDouble() < share).forEach(chosen::add);
        return chosen.isEmpty() ? Optional.empty() : Optional.of(chosen);
    }

    private <T> T any(List<T> all) {
        return all.get(random.nextInt(all.size()));
    }

    private void count(String what) {
        operations++;
        seen.merge(what, 1, Integer::sum);
    }

    private void comeOrGo() throws IOException {
        if (!clients.isEmpty() && random.nextInt(4) == 0) {
            leave(any(List.copyOf(clients.values())));
            return;
        }
        Holder holder = any(holders);
        String name = random.nextInt(8) == 0 ? "agent" + random.nextInt(9) : holder.name;
        Role role = random.nextInt(3) > 0 ? Role.AGENT : any(List.of(Role.values()));
        Optional<String> body = random.nextInt(3) > 0 ? Optional.empty() : Optional.of(any(ITEMS));
        Optional<String> secret =
                switch (random.nextInt(10)) {
                    case 0 -> Optional.empty();
                    case 1 -> Optional.of(AgentToken.newSecret());
                    default -> Optional.of(holder.secret);
                };
        hello(holder, name, role, body, secret);
    }

    private void hello(
            Holder holder, String name, Role role, Optional<String> body, Optional<String> secret)
            throws IOException {
        boolean right = secret.isPresent() && secret.get().equals(holder.secret);
        TestClient connection = new TestClient(connected(!right));
        connection.say(
                "{'t':'hello','protocol':1,'name':'"
                        + name
                        + "'"
                        + ",'role':'"
                        + role.wireName()
                        + "'"
                        + body.map(item -> ",'body':'" + item + "'").orElse("")
                        + secret.map(token -> ",'token':'" + token + "'").orElse("")
                        + "}");
        room.stepUntil("hello is answered", connection::hasNews);
        JsonNode answer = connection.next();
        var client = new Client(holder, role, connection);
        String verdict = verdict(holder, name, role, body, right, client);
        if (!verdict.isEmpty()) {
            assertThat(answer.path("code").asString(answer.toString()))
                    .as("%s as %s wants %s of %s", name, role, body, holder)
                    .isEqualTo(verdict);
            connection.close();
            count(verdict);
            return;
        }
        assertThat(answer.get("t").stringValue()).as("%s", answer).isEqualTo("welcome");
        assertThat(answer.path("body").asString(""))
                .isEqualTo(client.body.map(Thing::name).orElse(""));
        clients.put(name, client);
        count("welcome");
    }

    /**
     * Returns the expected result of a hello: a code, or an empty text if the hello is accepted.
     * After an accepted hello, the model's client has its body.
     */
    private String verdict(
            Holder holder,
            String name,
            Role role,
            Optional<String> body,
            boolean right,
            Client client) {
        if (!right) {
            return "bad-token";
        }
        Rights rights = holder.rights;
        if (!holder.name.equals(name)
                || !rights.roles().contains(role)
                || !opens(rights.worlds(), "pond")) {
            return "not-permitted";
        }
        if (clients.containsKey(name)) {
            return "name-taken";
        }
        if (role != Role.AGENT) {
            return "";
        }
        Set<String> taken = new TreeSet<>();
        clients.values().forEach(other -> other.body.ifPresent(owned -> taken.add(owned.name)));
        if (body.isPresent()) {
            String wanted = body.get();
            if (!opens(rights.bodies(), wanted)) {
                return "not-permitted";
            }
            if (!LENT.contains(wanted)) {
                return "no-such-body";
            }
            client.body = Optional.of(BY_NAME.get(wanted));
            return taken.contains(wanted) ? "body-taken" : "";
        }
        client.body =
                LENT.stream()
                        .filter(item -> !taken.contains(item) && opens(rights.bodies(), item))
                        .findFirst()
                        .map(BY_NAME::get);
        return client.body.isEmpty() ? "no-body-free" : "";
    }

    /**
     * Wrong tokens come from a separate address. Therefore the limit of wrong tokens does not
     * affect the other clients.
     */
    private Socket connected(boolean fromElsewhere) throws IOException {
        var socket = new Socket();
        if (fromElsewhere) {
            wrongTokens++;
            InetAddress elsewhere =
                    InetAddress.getByAddress(
                            new byte[] {
                                127,
                                (byte) (1 + wrongTokens / 60_000),
                                (byte) (wrongTokens / 250),
                                (byte) (1 + wrongTokens % 250)
                            });
            socket.bind(new InetSocketAddress(elsewhere, 0));
        }
        socket.connect(room.server.address());
        return socket;
    }

    private void leave(Client client) throws IOException {
        client.connection.say("{'t':'bye'}").skipToBye("goodbye");
        client.connection.close();
        clients.remove(client.holder.name);
        long agents = clients.values().stream().filter(other -> other.role == Role.AGENT).count();
        room.stepUntil("it has left", () -> room.server.stats().agents() == agents);
        room.step(); // in which its body becomes free
        count("goodbye");
    }

    private void act() throws IOException {
        var expected = new ArrayList<Map<Long, String>>();
        List<Client> doing = List.copyOf(clients.values());
        for (Client client : doing) {
            expected.add(ask(client));
            client.connection.sync();
        }
        room.step();
        for (int i = 0; i < doing.size(); i++) {
            listen(doing.get(i), expected.get(i));
        }
        for (Client client : doing) {
            if (client.errors >= MAX_ERRORS) {
                leave(client);
            }
        }
    }

    /**
     * Sends some messages.
     *
     * @return the expected answer for each id
     */
    private Map<Long, String> ask(Client client) throws IOException {
        var expected = new HashMap<Long, String>();
        for (int i = 1 + random.nextInt(20); i > 0; i--) {
            List<Long> known = List.copyOf(client.answered.keySet());
            if (!known.isEmpty() && client.role == Role.AGENT && random.nextInt(10) == 0) {
                long id = any(known);
                if (expected.putIfAbsent(id, client.answered.get(id)) == null) {
                    client.connection.say(act(id, any(ITEMS), any(ACTIONS), any(ITEMS)));
                    count("again");
                }
            } else if (random.nextInt(12) == 0) {
                expected.put(perceive(client), "perceived");
                return expected;
            } else if (random.nextInt(12) == 0 && client.errors < MAX_ERRORS) {
                long id = ++client.lastId;
                client.connection.say(
                        "{'t':'edit','id':"
                                + id
                                + ",'item':'duck','property':'semantic.note','value':"
                                + id
                                + "}");
                expected.put(id, client.role == Role.CONTROL ? "edited" : "not-permitted");
                client.errors += client.role == Role.CONTROL ? 0 : 1;
            } else if (client.role == Role.AGENT || client.errors < MAX_ERRORS) {
                expected.putAll(act(client));
            }
        }
        return expected;
    }

    private Map<Long, String> act(Client client) throws IOException {
        long id = ++client.lastId;
        String item = any(ITEMS);
        String action = any(ACTIONS);
        String other = any(ITEMS.subList(1, ITEMS.size()));
        client.connection.say(act(id, item, action, other));
        if (client.role != Role.AGENT) {
            client.errors++;
            return Map.of(id, "not-permitted");
        }
        String verdict = client.verdict(item, action, other);
        if (verdict.isEmpty()) {
            pushes.merge(item, 1.0, Double::sum);
        }
        client.answered.put(id, verdict.isEmpty() ? "done" : verdict);
        if (client.answered.size() > 200) {
            client.answered.remove(client.answered.keySet().iterator().next());
        }
        return Map.of(id, verdict.isEmpty() ? "done" : verdict);
    }

    private static String act(long id, String item, String action, String other) {
        return "{'t':'act','id':"
                + id
                + ",'item':'"
                + item
                + "','action':'"
                + action
                + "','arguments':{'impulse':[1,0,0]"
                + (action.equals("throw") ? ",'other':'" + other + "'" : "")
                + "}}";
    }

    private long perceive(Client client) throws IOException {
        long id = ++client.lastId;
        client.connection.say("{'t':'perceive','id':" + id + "}");
        return id;
    }

    /** Reads all answers, which must be as expected. */
    private void listen(Client client, Map<Long, String> expected) throws IOException {
        while (!expected.isEmpty()) {
            JsonNode message = client.connection.next();
            String type = message.get("t").stringValue();
            if (type.equals("event")) {
                continue;
            }
            long id = message.path("id").asLong(-1);
            String wanted = expected.remove(id);
            switch (type) {
                case "perception" -> {
                    assertThat(wanted).isEqualTo("perceived");
                    assertThat(names(message))
                            .as("what %s perceives", client.holder)
                            .isEqualTo(sensed(client));
                }
                case "result" -> {
                    String done = client.role == Role.CONTROL ? "edited" : "done";
                    assertThat(
                                    message.get("accepted").booleanValue()
                                            ? done
                                            : message.get("code").stringValue())
                            .as("%s with %s gets %s", client.holder, client.body, message)
                            .isEqualTo(wanted);
                }
                default ->
                        assertThat(message.path("code").asString(""))
                                .as("%s", message)
                                .isEqualTo(wanted);
            }
            count(wanted);
        }
    }

    private static Set<String> names(JsonNode perception) {
        Set<String> names = new TreeSet<>();
        perception
                .get("items")
                .values()
                .forEach(
                        item -> {
                            names.add(item.get("name").stringValue());
                        });
        return names;
    }

    private static Set<String> sensed(Client client) {
        Set<String> names = new TreeSet<>();
        THINGS.stream().filter(client::senses).forEach(thing -> names.add(thing.name));
        return names;
    }
}
