// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Operand;
import reve.core.access.Terms;
import reve.core.agent.AgentRoom;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.TestClient;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Role;
import reve.core.file.AgentPolicy;
import reve.core.world.ItemDefinition;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.nio.file.Path;
import java.time.Instant;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/** The effect of each token on joining, and on rights afterwards. */
class RightsTest {

    private static final Instant NOW = Instant.parse("2030-01-01T00:00:00Z");
    private static final Optional<Set<String>> ANY = Optional.empty();

    @TempDir private Path folder;
    private Path file;
    private volatile Instant now = NOW;
    private AgentRoom room;

    @BeforeEach
    void openARoomWithTokens() throws IOException {
        file = folder.resolve("tokens.json");
        issue("nobody", new Rights(Set.of(Role.OBSERVER), ANY, ANY, ANY, false));
        AgentServerConfig config =
                AgentServerConfig.on(
                        AgentRoom.CONFIG.address(),
                        new AgentSecurity(
                                Optional.of(TokenFile.open(file, () -> now)), Optional.empty()));
        room =
                new AgentRoom(
                        config,
                        new AgentPolicy(List.of("boat", "raft"), AgentRoom.making().template()),
                        4096,
                        List.of(AgentRoom.duck(), item("boat"), item("raft"), crate()));
    }

    @AfterEach
    void close() {
        room.close();
    }

    private static ItemDefinition item(String name) {
        return ItemDefinition.named(name).at(0, 0, 0).capability("lift").capability("push").build();
    }

    private static ItemDefinition crate() {
        return ItemDefinition.named("crate")
                .at(1, 0, 0)
                .action(
                        new DeclaredAction(
                                "lift",
                                "Lifts it.",
                                List.of(),
                                new Terms(List.of("lift"), List.of()),
                                List.of(new Effect.SetSymbol("lifted", new Operand.Symbol(true)))))
                .build();
    }

    private String issue(String name, Rights rights) throws IOException {
        return issue(name, rights, Optional.empty());
    }

    private String issue(String name, Rights rights, Optional<Instant> expires) throws IOException {
        AgentToken.Issued issued = AgentToken.issue(name, rights, expires);
        TokenFile.add(file, issued.token());
        return issued.secret();
    }

    private static Rights agent(
            Optional<Set<String>> worlds,
            Optional<Set<String>> bodies,
            Optional<Set<String>> capabilities) {
        return new Rights(Set.of(Role.AGENT), worlds, bodies, capabilities, false);
    }

    /** Sends a hello and waits for the answer. */
    private TestClient hello(String name, String rest) throws IOException {
        TestClient client =
                room.connect().say("{'t':'hello','protocol':1,'name':'" + name + "'" + rest + "}");
        room.stepUntil("hello was answered", client::hasNews);
        return client;
    }

    private JsonNode refused(String name, String rest, String code) throws IOException {
        try (TestClient client = hello(name, rest)) {
            return client.expectBye(code);
        }
    }

    private TestClient welcomed(String name, String token) throws IOException {
        TestClient client = hello(name, ",'token':'" + token + "'");
        client.expect("welcome");
        return client;
    }

    @Test
    void aWrongTokenAndNoneAreRefusedAlikeAndOnesOwnOpens() throws IOException {
        String token = issue("ada", agent(ANY, ANY, ANY));
        JsonNode none = refused("ada", "", "bad-token");
        JsonNode wrong = refused("ada", ",'token':'" + "0".repeat(32) + "'", "bad-token");
        assertThat(wrong).isEqualTo(none);
        welcomed("ada", token).close();
    }

    @Test
    void aTokenOpensItsNameItsRolesAndItsWorlds() throws IOException {
        String ada = issue("ada", agent(Optional.of(Set.of("pond")), ANY, ANY));
        String bob = issue("bob", agent(Optional.of(Set.of("sea")), ANY, ANY));
        refused("eve", ",'token':'" + ada + "'", "not-permitted");
        refused("ada", ",'role':'control','token':'" + ada + "'", "not-permitted");
        refused("ada", ",'role':'observer','token':'" + ada + "'", "not-permitted");
        refused("bob", ",'token':'" + bob + "'", "not-permitted");
        welcomed("ada", ada).close();
    }

    /** Otherwise the holder of a token could try names of worlds that it hides. */
    @Test
    void theAnswerDoesNotTellWhichWorldsExist() throws IOException {
        String bob = ",'token':'" + issue("bob", agent(Optional.of(Set.of("sea")), ANY, ANY)) + "'";
        JsonNode exists = refused("bob", ",'world':'pond'" + bob, "not-permitted");
        JsonNode invented = refused("bob", ",'world':'lake'" + bob, "not-permitted");
        assertThat(exists.toString().replace("pond", "lake")).isEqualTo(invented.toString());
        assertThat(refused("bob", bob, "not-permitted").toString()).doesNotContain("pond");
    }

    @Test
    void controlTakesATokenThatSaysSo() throws IOException {
        String token = issue("boss", new Rights(Set.of(Role.CONTROL), ANY, ANY, ANY, false));
        refused("boss", ",'role':'control'", "bad-token");
        try (TestClient boss = hello("boss", ",'role':'control','token':'" + token + "'")) {
            boss.expect("welcome");
            boss.say("{'t':'pause','id':1}");
            assertThat(boss.skipTo("result").get("accepted").booleanValue()).isTrue();
        }
    }

    @Test
    void aTokenMayPermitChangesOfSingleLawsAndParametersOnly() throws IOException {
        Optional<Set<String>> laws = Optional.of(Set.of("wind", "drag.c"));
        Rights rights = new Rights(Set.of(Role.CONTROL), ANY, ANY, ANY, false, laws);
        String token = issue("boss", rights);
        String[] permitted = {
            "{'t':'set-law','id':1,'library':'wind','parameters':{'any':1}}",
            "{'t':'set-law','id':2,'library':'drag','parameters':{'c':1}}",
            "{'t':'set-law','id':21,'library':'drag','parameters':{'drag.c':1}}",
            "{'t':'unload-law','id':3,'library':'wind'}",
            "{'t':'load-law','id':4,'library':'wind'}",
        };
        String[] refused = {
            "{'t':'set-law','id':11,'library':'drag','parameters':{'c':1,'d':1}}",
            "{'t':'set-law','id':12,'library':'drag','parameters':{}}",
            "{'t':'set-law','id':13,'library':'gravity','parameters':{'c':1}}",
            "{'t':'unload-law','id':14,'library':'drag'}",
            "{'t':'pause','id':15}",
            "{'t':'edit','id':16,'item':'duck','property':'mass','value':3}",
            "{'t':'remove','id':17,'item':'duck'}",
            "{'t':'fork','id':18,'frames':1}",
            "{'t':'rewind','id':19}",
            "{'t':'ledger','id':20,'open':true}",
            "{'t':'shut-down','id':21}",
            "{'t':'audit','id':22}",
        };
        try (TestClient boss = hello("boss", ",'role':'control','token':'" + token + "'")) {
            boss.expect("welcome");
            for (String request : permitted) {
                boss.say(request); // this room has no laws
                assertThat(boss.skipTo("result").get("code").stringValue())
                        .as(request)
                        .isEqualTo("unsupported");
            }
        }
        for (int i = 0; i < refused.length; i++) { // a connection ends after some errors
            String request = refused[i];
            String other = issue("boss" + i, rights);
            try (TestClient boss = hello("boss" + i, ",'role':'control','token':'" + other + "'")) {
                boss.expect("welcome");
                boss.say(request);
                JsonNode error = boss.skipTo("error");
                assertThat(error.get("code").stringValue()).as(request).isEqualTo("not-permitted");
                assertThat(error.get("hint").stringValue())
                        .as(request)
                        .startsWith("it may change only the laws drag.c, wind");
            }
        }
    }

    /** A hello that asks for the cluster needs the token of a session, and one for all worlds. */
    @Test
    void aTokenForSomeWorldsDoesNotAskForTheCluster() throws IOException {
        Set<Role> control = Set.of(Role.CONTROL);
        String boss = issue("boss", new Rights(control, ANY, ANY, ANY, false));
        String warden =
                issue("warden", new Rights(control, Optional.of(Set.of("pond")), ANY, ANY, false));
        String ada = issue("ada", agent(ANY, ANY, ANY));
        String question = ",'role':'control','ask':'cluster','token':'";
        refused("boss", question + boss + "'", "unsupported"); // this room belongs to no cluster
        refused("warden", question + warden + "'", "not-permitted");
        refused("ada", question + ada + "'", "not-permitted");
        refused("eve", question + boss + "'", "not-permitted");
        refused("boss", question + "0".repeat(32) + "'", "bad-token");
        refused("boss", ",'role':'control','ask':'cluster'", "bad-token");
    }

    /** An order to a cluster may concern worlds other than that of the client. */
    @Test
    void aTokenForSomeWorldsPermitsNoOrders() throws IOException {
        Rights all = new Rights(Set.of(Role.CONTROL), ANY, ANY, ANY, false);
        Rights some =
                new Rights(
                        Set.of(Role.CONTROL), Optional.of(Set.of("pond", "lake")), ANY, ANY, false);
        String lake = "{'t':'move-world','id':1,'world':'lake','node':'a:1'}";
        String sea = "{'t':'move-world','id':2,'world':'sea','node':'a:1'}";
        String drain = "{'t':'drain-node','id':3,'node':'a:1'}";
        String add = "{'t':'add-world','id':4,'text':'reve: 1'}";
        String boss = issue("boss", all);
        try (TestClient client = hello("boss", ",'role':'control','token':'" + boss + "'")) {
            client.expect("welcome");
            for (String order : List.of(lake, sea, drain, add)) {
                client.say(order); // this room belongs to no cluster
                assertThat(client.skipTo("result").get("code").stringValue())
                        .as(order)
                        .isEqualTo("unsupported");
            }
        }
        String warden = issue("warden", some);
        try (TestClient client = hello("warden", ",'role':'control','token':'" + warden + "'")) {
            client.expect("welcome");
            for (String order : List.of(lake, sea, drain, add)) {
                client.say(order);
                JsonNode error = client.skipTo("error");
                assertThat(error.get("code").stringValue()).as(order).isEqualTo("not-permitted");
                assertThat(error.get("hint").stringValue())
                        .isEqualTo("it opens only some worlds, and the order is about all worlds");
            }
        }
    }

    @Test
    void theWorldWaitsOnlyForWhoseTokenSaysSo() throws IOException {
        String lockStep = ",'time':{'mode':'lock-step'},'token':'";
        refused("ada", lockStep + issue("ada", agent(ANY, ANY, ANY)) + "'", "not-permitted");
        String bob = issue("bob", new Rights(Set.of(Role.AGENT), ANY, ANY, ANY, true));
        try (TestClient client = hello("bob", lockStep + bob + "'")) {
            assertThat(client.expect("welcome").get("time").get("mode").stringValue())
                    .isEqualTo("lock-step");
        }
    }

    @Test
    void anExpiredTokenOpensNothing() throws IOException {
        String token = issue("ada", agent(ANY, ANY, ANY), Optional.of(NOW));
        refused("ada", ",'token':'" + token + "'", "bad-token");
    }

    @Test
    void aTokenWithBodiesGivesOneOfTheseOrNone() throws IOException {
        String ada = issue("ada", agent(ANY, Optional.of(Set.of("raft")), ANY));
        String bob = issue("bob", agent(ANY, Optional.of(Set.of("raft")), ANY));
        refused("ada", ",'body':'boat','token':'" + ada + "'", "not-permitted");
        try (TestClient client = hello("ada", ",'token':'" + ada + "'")) {
            assertThat(client.expect("welcome").get("body").stringValue()).isEqualTo("raft");
            refused("bob", ",'token':'" + bob + "'", "no-body-free");
        }
    }

    @Test
    void anAgentBearsTheNameOfNoItemButItsOwnBody() throws IOException {
        String crate = issue("crate", agent(ANY, ANY, ANY));
        String raft = issue("raft", agent(ANY, ANY, ANY));
        String boat = issue("boat", agent(ANY, Optional.of(Set.of("raft")), ANY));
        JsonNode taken = refused("crate", ",'token':'" + crate + "'", "name-taken");
        assertThat(refused("crate", ",'body':'boat','token':'" + crate + "'", "name-taken"))
                .isEqualTo(taken);
        assertThat(refused("boat", ",'token':'" + boat + "'", "name-taken").toString())
                .as("alike")
                .isEqualTo(taken.toString().replace("crate", "boat"));
        refused("raft", ",'body':'boat','token':'" + raft + "'", "name-taken");
        try (TestClient client = hello("raft", ",'token':'" + raft + "'")) {
            assertThat(client.expect("welcome").get("body").stringValue()).isEqualTo("raft");
        }
    }

    /** The server also hides other worlds from such a token in `hello` and in the metrics. */
    @Test
    void aTokenForSomeWorldsDoesNotLearnOfTheOthersInTheCluster() {
        var question = new ClientMessage.Ask(1, "cluster", Map.of());
        var ofPond = new Rights(Set.of(Role.CONTROL), Optional.of(Set.of("pond")), ANY, ANY, false);
        assertThat(ofPond.refusal(question))
                .hasValueSatisfying(
                        why -> {
                            assertThat(why).contains("only some worlds");
                        });
        assertThat(ofPond.refusal(new ClientMessage.Ask(1, "profile", Map.of()))).isEmpty();
        assertThat(Rights.ALL.refusal(question)).isEmpty();
    }

    @Test
    void aTokenWithCapabilitiesLimitsThoseOfTheBody() throws IOException {
        String ada = issue("ada", agent(ANY, ANY, Optional.of(Set.of("push", "fly"))));
        String bob = issue("bob", agent(ANY, ANY, Optional.of(Set.of("lift"))));
        try (TestClient weak = welcomed("ada", ada);
                TestClient strong = welcomed("bob", bob)) {
            weak.say("{'t':'act','id':1,'item':'crate','action':'lift'}").sync();
            strong.say("{'t':'act','id':1,'item':'crate','action':'lift'}").sync();
            room.step();
            JsonNode refusal = weak.skipTo("result");
            assertThat(refusal.path("code").asString("")).isEqualTo("not-capable");
            assertThat(refusal.get("reason").stringValue())
                    .contains("only `push`")
                    .contains("token");
            assertThat(strong.skipTo("result").get("accepted").booleanValue()).isTrue();
        }
    }

    @ParameterizedTest
    @ValueSource(booleans = {true, false})
    void whoseTokenIsRevokedLeavesTheWorldConnectedOrNot(boolean connected) throws IOException {
        String token = issue("ada", agent(ANY, ANY, ANY));
        TestClient ada = hello("ada", ",'graceSeconds':60,'token':'" + token + "'");
        assertThat(ada.expect("welcome").get("body").stringValue()).isEqualTo("boat");
        if (!connected) {
            ada.close();
        }
        TokenFile.revoke(file, "ada");
        room.stepUntil("it has left", () -> room.server.stats().agents() == 0);
        if (connected) {
            ada.skipToBye("token-revoked");
            ada.close();
        }
        refused("ada", ",'token':'" + token + "'", "bad-token");
    }

    @Test
    void anAddressThatGuessesIsCutAndStillTakesTheRightTokensOfOthers() throws IOException {
        String token = issue("ada", agent(ANY, ANY, ANY));
        String bob = issue("bob", agent(ANY, ANY, ANY));
        TestClient before = hello("bob", ",'graceSeconds':60,'token':'" + bob + "'");
        String session = before.expect("welcome").get("session").get("token").stringValue();
        before.close();
        String last = "";
        for (int i = 0; i < 100 && !last.equals("too-many-attempts"); i++) {
            try (TestClient client = hello("ada", ",'token':'" + "0".repeat(32) + "'")) {
                last = client.expect("bye").get("code").stringValue();
                assertThat(last).isIn("bad-token", "too-many-attempts");
                assertThat(i < Attempts.BURST && !last.equals("bad-token"))
                        .as("attempt %s was %s", i, last)
                        .isFalse();
            }
        }
        assertThat(last).isEqualTo("too-many-attempts");
        assertThat(room.server.stats().cut()).isEqualTo(1);
        welcomed("ada", token).close();
        refused("eve", ",'resume':{'session':'" + token + "','frame':0}", "too-many-attempts");
        try (TestClient again = hello("bob", ",'resume':{'session':'" + session + "','frame':1}")) {
            assertThat(again.expect("welcome").get("resumed").booleanValue()).isTrue();
        }
    }

    @Test
    void aSessionIsResumedByItsOwnSecretAndGuessingThatCountsToo() throws IOException {
        String token = issue("ada", agent(ANY, ANY, ANY));
        TestClient first = hello("ada", ",'graceSeconds':60,'token':'" + token + "'");
        String session = first.expect("welcome").get("session").get("token").stringValue();
        first.close();
        refused("ada", ",'resume':{'session':'" + token + "','frame':0}", "no-such-session");
        try (TestClient again = hello("ada", ",'resume':{'session':'" + session + "','frame':1}")) {
            assertThat(again.expect("welcome").get("resumed").booleanValue()).isTrue();
        }
    }

    @Test
    void aServerWithoutTokensOnLoopbackIgnoresThem() throws IOException {
        try (AgentRoom open = new AgentRoom();
                TestClient client = open.connect()) {
            client.say("{'t':'hello','protocol':1,'name':'ada','token':'whatever'}").sync();
            open.step();
            client.expect("welcome");
        }
    }

    @Test
    void tokensComeBeforeWhatTheServerKnowsOfNames() throws IOException {
        String token = issue("ada", agent(ANY, ANY, ANY));
        try (TestClient ada = welcomed("ada", token)) {
            refused("ada", "", "bad-token"); // and not name-taken
            assertThat(ada.socket.isClosed()).isFalse();
        }
    }

    @Test
    void anIdleServerSeesThatATokenHasExpired() throws IOException {
        String token = issue("ada", agent(ANY, ANY, ANY), Optional.of(NOW.plusSeconds(1)));
        try (TestClient ada = welcomed("ada", token)) {
            now = NOW.plusSeconds(1);
            ada.skipToBye("token-revoked");
        }
    }
}
