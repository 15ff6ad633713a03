// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.agent.audit.AuditPlan;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.nio.file.Path;
import java.util.List;
import java.util.concurrent.TimeUnit;
import java.util.function.Predicate;

/** The report of the newest records of the audit log. */
class AuditReportTest {
    @TempDir private Path folder;
    private AgentRoom room;

    @BeforeEach
    void open() throws IOException {
        room =
                new AgentRoom(
                        AgentRoom.CONFIG.withAudit(AuditPlan.of(folder.resolve("audit.jsonl"))));
    }

    @AfterEach
    void close() {
        room.close();
    }

    private static TestClient watcher(AgentRoom room, String role) throws IOException {
        TestClient client = room.connect();
        client.say("{'t':'hello','protocol':1,'name':'" + role + "','role':'" + role + "'}");
        client.expect("welcome");
        return client;
    }

    /** Asks until the report fits. Records are written by another thread. */
    private static JsonNode awaitReport(TestClient boss, String fields, Predicate<String> fits)
            throws IOException {
        long end = System.nanoTime() + TimeUnit.MINUTES.toNanos(5);
        for (int id = 100; ; id++) {
            boss.say("{'t':'audit','id':" + id + fields + "}");
            JsonNode report = boss.skipTo("report");
            if (fits.test(report.toString())) {
                return report;
            }
            assertThat(System.nanoTime()).as("%s", report).isLessThan(end);
        }
    }

    private static List<String> types(JsonNode report) {
        return report.at("/content/records")
                .valueStream()
                .map(record -> record.get("type").stringValue())
                .toList();
    }

    @Test
    void theRoleControlReadsTheNewestRecordsWithoutSecrets() throws IOException {
        try (TestClient ada = room.connect();
                TestClient boss = watcher(room, "control")) {
            ada.say("{'t':'hello','protocol':1,'name':'ada','graceSeconds':30}").sync();
            room.step();
            String secret = ada.expect("welcome").at("/session/token").stringValue();
            ada.say("{'t':'act','id':5,'item':'swan','action':'push'}").sync();
            room.step();
            ada.skipTo("result");

            JsonNode report =
                    awaitReport(boss, ",'client':'ada','most':200", text -> text.contains("swan"));
            assertThat(report.get("of").stringValue()).isEqualTo("audit");
            assertThat(report.at("/content/unrecorded").longValue()).isZero();
            assertThat(types(report)).containsSubsequence("result", "event", "welcome");
            JsonNode welcome = report.at("/content/records").get(types(report).indexOf("welcome"));
            assertThat(welcome.get("client").stringValue()).isEqualTo("ada");
            assertThat(welcome.get("message").stringValue())
                    .startsWith("{\"t\":\"welcome\"")
                    .contains("\"session\":{\"token\":\"…\"");
            assertThat(report.toString()).doesNotContain(secret);

            JsonNode one = awaitReport(boss, ",'most':1", any -> true);
            assertThat(types(one)).hasSize(1);
        }
    }

    /** A report that contained the report before it would double in length each time. */
    @Test
    void reportsOfRecordsDoNotContainEachOther() throws IOException {
        try (TestClient boss = watcher(room, "control")) {
            JsonNode first = awaitReport(boss, "", text -> text.contains("welcome"));
            for (int i = 0; i < 30; i++) {
                awaitReport(boss, ",'frequent':true", any -> true);
            }
            JsonNode last =
                    awaitReport(
                            boss,
                            ",'frequent':true",
                            text -> text.split("\"type\":\"report\"", -1).length > 30);
            assertThat(last.toString().length()).isLessThan(60 * first.toString().length());
            last.at("/content/records")
                    .valueStream()
                    .filter(record -> record.get("type").stringValue().equals("report"))
                    .forEach(
                            record ->
                                    assertThat(record.get("message").stringValue())
                                            .contains("\"records\":\"sha256:"));
        }
    }

    @Test
    void otherRolesAreRefused() throws IOException {
        try (TestClient ada = room.join("ada");
                TestClient eve = watcher(room, "observer")) {
            for (TestClient client : List.of(ada, eve)) {
                client.say("{'t':'audit','id':1}");
                assertThat(client.skipTo("error").get("code").stringValue())
                        .isEqualTo("not-permitted");
            }
        }
        try (TestClient boss = watcher(room, "control")) {
            boss.say("{'t':'audit','id':1,'most':201}");
            assertThat(boss.skipTo("error").get("code").stringValue()).isEqualTo("bad-field");
        }
    }

    @Test
    void aServerWithoutARecordSaysSo() throws IOException {
        try (var other = new AgentRoom();
                TestClient boss = watcher(other, "control")) {
            boss.say("{'t':'audit','id':1}");
            JsonNode refused = boss.skipTo("result");
            assertThat(refused.get("code").stringValue()).isEqualTo("unsupported");
            assertThat(refused.get("reason").stringValue()).contains("serve --audit FILE");
        }
    }
}
