// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;
import org.junit.jupiter.params.provider.ValueSource;

/** The URLs of stores in databases. */
class PostgresUrlTest {
    private static PostgresUrl url(String text) {
        return PostgresUrl.find(text).orElseThrow();
    }

    @Test
    void aUrlNamesHostPortDatabaseAndUser() {
        PostgresUrl url = url("postgresql://ada@db.example:6000/worlds");
        assertThat(url.host()).isEqualTo("db.example");
        assertThat(url.port()).isEqualTo(6000);
        assertThat(url.database()).isEqualTo("worlds");
        assertThat(url.user()).isEqualTo("ada");
        assertThat(url.forDriver()).isEqualTo("jdbc:postgresql://db.example:6000/worlds");
        assertThat(url).hasToString("postgresql://ada@db.example:6000/worlds");
    }

    @Test
    void partsHaveDefaultsAndMayBeEncoded() {
        assertThat(url("postgres://h/w").port()).isEqualTo(5432);
        assertThat(url("postgres://h/w").user()).isEqualTo(System.getProperty("user.name"));
        PostgresUrl odd = url("postgresql://a%40b@[::1]:7/my%20worlds%3F");
        assertThat(odd.user()).isEqualTo("a@b");
        assertThat(odd.host()).isEqualTo("::1");
        assertThat(odd.database()).isEqualTo("my worlds?");
        assertThat(odd.forDriver()).isEqualTo("jdbc:postgresql://[::1]:7/my%20worlds%3F");
        assertThat(url(odd.toString())).isEqualTo(odd);
    }

    @ParameterizedTest
    @CsvSource({
        "postgresql://a@127.0.0.1/w, prefer",
        "postgresql://a@localhost/w, prefer",
        "postgresql://a@[::1]/w, prefer",
        "postgresql://a@10.0.0.7/w, verify-full",
        "postgresql://a@localhost.example/w, verify-full",
        "postgresql://a@10.0.0.7/w?sslmode=require, require"
    })
    void aConnectionToAnotherMachineIsVerifiedUnlessTheUrlSaysOtherwise(String text, String mode) {
        assertThat(url(text).properties().getProperty("sslmode")).isEqualTo(mode);
    }

    @ParameterizedTest
    @ValueSource(strings = {"my.db", "/tmp/my.db", "a:b", "://x", "folder/postgresql"})
    void otherTextsAreFiles(String text) {
        assertThat(PostgresUrl.find(text)).isEmpty();
    }

    @ParameterizedTest
    @CsvSource({
        "mysql://a@h/w, of the kind mysql://",
        "postgresql://a@h, names no database",
        "postgresql://a@h/, names no database",
        "postgresql://a@h/w/x, names no database",
        "postgresql:///w, names no host",
        "postgresql://a@h/w?user=b, the setting user",
        "postgresql://a@h/w?sslmode=maybe, sslmode=maybe",
        "postgresql://a@h/w w, broken at character 19",
        "postgresql://a:secret@h/w, contains a password",
        "postgresql://a:secret@h h/w, broken at character"
    })
    void otherUrlsAreRefusedWithoutTheirPassword(String text, String message) {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> PostgresUrl.find(text))
                .withMessageContaining(message)
                .satisfies(refused -> assertThat(refused.toString()).doesNotContain("secret"));
    }
}
