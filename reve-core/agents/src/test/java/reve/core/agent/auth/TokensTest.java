// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.junit.jupiter.api.Assumptions.assumeTrue;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.agent.protocol.Role;

import java.io.IOException;
import java.net.InetAddress;
import java.nio.file.FileSystemException;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.nio.file.attribute.FileTime;
import java.nio.file.attribute.PosixFilePermissions;
import java.time.Instant;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.Set;
import java.util.concurrent.TimeUnit;

/** Tokens and the file in which they are kept. */
class TokensTest {

    private static final Instant NOW = Instant.parse("2030-01-01T00:00:00Z");

    @TempDir private Path folder;
    private Path file;
    private Instant now = NOW;

    @BeforeEach
    void nameTheFile() {
        file = folder.resolve("tokens.json");
    }

    private String add(String name) throws IOException {
        return add(name, Rights.ALL, Optional.empty());
    }

    private String add(String name, Rights rights, Optional<Instant> expires) throws IOException {
        AgentToken.Issued issued = AgentToken.issue(name, rights, expires);
        TokenFile.add(file, issued.token());
        return issued.secret();
    }

    @Test
    void aLinkLeadsToTheFileThatIsChanged() throws IOException {
        String secret = add("ada");
        Path servers = file;
        TokenFile tokens = TokenFile.open(servers, () -> now);
        file = Files.createSymbolicLink(folder.resolve("link.json"), servers);
        add("bob");
        assertThat(TokenFile.revoke(file, "ada")).hasSize(1);
        assertThat(file).isSymbolicLink();
        assertThat(tokens.find(secret)).isEmpty();
        assertThat(tokens.tokens()).extracting(AgentToken::name).containsExactly("bob");
        Files.delete(servers);
        assertThatThrownBy(() -> add("eve"))
                .isInstanceOf(NoSuchFileException.class)
                .hasMessageContaining(file + " is a link to a file that is not there");
        assertThat(file).isSymbolicLink();
    }

    /** Otherwise the server of that account would not see that root has revoked a token. */
    @Test
    void aChangeByRootKeepsTheOwnerOfTheFile() throws IOException {
        add("ada");
        int nobody = 65534;
        try {
            Files.setAttribute(file, "unix:uid", nobody);
        } catch (FileSystemException e) {
            assumeTrue(false, "only root can give a file to another account");
        }
        TokenFile.revoke(file, "ada");
        assertThat(TokenFile.open(file).tokens()).isEmpty();
        assertThat(Files.getAttribute(file, "unix:uid")).isEqualTo(nobody);
        Path lock = folder.resolve(".tokens.json.lock");
        assertThat(Files.getAttribute(lock, "unix:uid")).isEqualTo(nobody);
    }

    @Test
    void aTokenIsFoundByItsSecretWithAllThatItSays() throws IOException {
        var rights =
                new Rights(
                        Set.of(Role.AGENT, Role.OBSERVER),
                        Optional.of(Set.of("pond")),
                        Optional.of(Set.of()),
                        Optional.of(Set.of("push", "lift heavy")),
                        true,
                        Optional.of(Set.of("wind", "drag.c")));
        add("bob");
        String secret = add("ada", rights, Optional.of(NOW.plusNanos(1)));
        TokenFile tokens = TokenFile.open(file, () -> now);
        assertThat(tokens.find(secret))
                .get()
                .isEqualTo(
                        new AgentToken(
                                "ada",
                                AgentToken.hash(secret),
                                rights,
                                Optional.of(NOW.plusNanos(1))));
        assertThat(tokens.find(secret.substring(1))).isEmpty();
        assertThat(tokens.find("")).isEmpty();
        now = NOW.plusNanos(1);
        assertThat(tokens.find(secret)).as("expired").isEmpty();
    }

    @Test
    void secretsAre128BitsThatDifferAndAreWrittenNowhere() throws IOException {
        String first = add("ada");
        String second = add("ada");
        assertThat(first).matches("[0-9a-f]{32}").isNotEqualTo(second);
        assertThat(Files.readString(file))
                .doesNotContain(first, second)
                .contains(AgentToken.hash(first));
        assertThat(AgentToken.issue("ada", Rights.ALL, Optional.empty()).toString())
                .doesNotContain("secret");
    }

    @Test
    void theHashIsSha256() {
        assertThat(AgentToken.hash("abc"))
                .isEqualTo("ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }

    @Test
    void theFileIsForItsOwnerAlone() throws IOException {
        add("ada");
        assertThat(PosixFilePermissions.toString(Files.getPosixFilePermissions(file)))
                .isEqualTo("rw-------");
        Files.setPosixFilePermissions(file, PosixFilePermissions.fromString("rw-r-----"));
        assertThatThrownBy(() -> TokenFile.open(file))
                .isInstanceOf(IOException.class)
                .hasMessageContaining("rw-r-----")
                .hasMessageContaining("chmod 600 " + file);
        assertThatThrownBy(() -> add("bob"))
                .isInstanceOf(IOException.class)
                .hasMessageContaining("chmod 600");
    }

    /** Reading a pipe would wait for a writer. */
    @Test
    void aPipeIsNoFileOfTokens() throws Exception {
        Path pipe = file.resolveSibling("pipe");
        assertThat(new ProcessBuilder("mkfifo", "-m", "600", pipe.toString()).start().waitFor())
                .isZero();
        assertThatThrownBy(() -> TokenFile.open(pipe))
                .isInstanceOf(IOException.class)
                .hasMessage(
                        pipe
                                + " is a pipe or a device, expected a file of tokens; name that "
                                + "file");
        assertThatThrownBy(() -> ServerTls.of(pipe, pipe))
                .isInstanceOf(IOException.class)
                .hasMessage(
                        pipe
                                + " is a pipe or a device, expected a file in PEM; name that "
                                + "file");
    }

    @Test
    void aMissingFileIsNamedWithTheCommandThatMakesIt() {
        assertThatThrownBy(() -> TokenFile.open(file))
                .isInstanceOf(NoSuchFileException.class)
                .hasMessageContaining("the command `token new NAME --file " + file);
    }

    @Test
    void aFolderIsNoFileOfTokensAndNoneIsMadeForOne() {
        Path folder = file.getParent();
        AgentToken token = AgentToken.issue("ada", Rights.ALL, Optional.empty()).token();
        assertThatThrownBy(() -> TokenFile.add(folder, token))
                .hasMessage(folder + " is a folder, expected a file of tokens");
        Path missing = folder.resolve("missing").resolve("tokens.json");
        assertThatThrownBy(() -> TokenFile.add(missing, token))
                .hasMessage(
                        "there is no folder "
                                + missing.getParent()
                                + " for tokens.json; make it first");
    }

    @Test
    void revokingTakesAllOfANameOrTheOneOfAnId() throws IOException {
        String ada = add("ada");
        add("bob");
        String other = add("bob");
        TokenFile tokens = TokenFile.open(file, () -> now);
        assertThat(TokenFile.revoke(file, AgentToken.hash(other).substring(0, 8))).hasSize(1);
        assertThat(tokens.tokens()).extracting(AgentToken::name).containsExactly("ada", "bob");
        assertThat(TokenFile.revoke(file, "bob")).hasSize(1);
        assertThat(TokenFile.revoke(file, "bob")).isEmpty();
        assertThat(tokens.find(ada)).isPresent();
        assertThat(tokens.find(other)).isEmpty();
    }

    @Test
    void aChangeWithTheSameSizeAndTimeIsSeen() throws IOException {
        String secret = add("ada");
        TokenFile tokens = TokenFile.open(file, () -> now);
        FileTime before = Files.getLastModifiedTime(file);
        Files.writeString(file, " ".repeat((int) Files.size(file)));
        Files.setLastModifiedTime(file, before);
        assertThat(tokens.find(secret)).isPresent();
        assertThat(tokens.problem()).isPresent();
    }

    @Test
    void anEmptyFileIsNotRead() throws IOException {
        String secret = add("ada");
        TokenFile tokens = TokenFile.open(file, () -> now);
        Files.write(file, new byte[0]);
        assertThat(tokens.find(secret)).isPresent();
        assertThat(tokens.problem()).get().asString().contains("it is empty");
    }

    @Test
    void aChangeThatCannotBeReadLeavesWhatWasThere() throws IOException {
        String secret = add("ada");
        TokenFile tokens = TokenFile.open(file, () -> now);
        Files.writeString(file, "{\"reveTokens\":1,\"tokens\":[");
        assertThat(tokens.find(secret)).isPresent();
        assertThat(tokens.problem()).get().asString().contains("it is not JSON");
        Files.delete(file);
        assertThat(tokens.find(secret)).isPresent();
        assertThat(tokens.problem()).get().asString().contains("there is no file of tokens");
        String next = add("bob");
        assertThat(tokens.find(secret)).isEmpty();
        assertThat(tokens.find(next)).isPresent();
        assertThat(tokens.problem()).isEmpty();
        Files.setPosixFilePermissions(file, PosixFilePermissions.fromString("rw-r--r--"));
        assertThat(tokens.find(next)).isPresent();
        assertThat(tokens.problem()).get().asString().contains("chmod 600 " + file);
        Files.setPosixFilePermissions(file, PosixFilePermissions.fromString("rw-------"));
        assertThat(tokens.problem()).isEmpty();
    }

    @ParameterizedTest
    @CsvSource(
            delimiter = '|',
            textBlock =
                    """
                    []                                                            | expected {"reveTokens": 1
                    {"reveTokens":2,"tokens":[]}                                  | expected {"reveTokens": 1
                    {"reveTokens":1,"tokens":[{"name":"a","bodys":["x"]}]}        | token 1 has the field "bodys"
                    {"reveTokens":1,"tokens":[{"name":"a","roles":["agent"]}]}    | sha256 is not a text
                    {"reveTokens":1,"tokens":[{"name":"a","sha256":"00"}]}        | sha256 of the token of a is not 64
                    {"reveTokens":1,"tokens":[{"name":"a","roles":["king"]}]}     | the role "king"
                    {"reveTokens":1,"tokens":[{"name":"a","roles":"agent"}]}      | roles is not a list of texts
                    {"reveTokens":1,"tokens":[{"name":"a b","sha256":"00"}]}      | "a b" is no name
                    {"reveTokens":1,"reveTokens":1,"tokens":[]}                   | it is not JSON: line 1, column 2
                    {"reveTokens":1,"tokens":[]}{"at":"2030"}                     | it is not JSON: line 1, column 2
                    """)
    void aFileThatSaysSomethingElseIsRefusedWhole(String content, String reason)
            throws IOException {
        add("ada");
        Files.writeString(file, content);
        assertThatThrownBy(() -> TokenFile.open(file))
                .isInstanceOf(IOException.class)
                .hasMessageContaining(file.toString())
                .hasMessageContaining(reason)
                .hasMessageNotContainingAny("JsonToken", "Feature", "Source:");
    }

    @ParameterizedTest
    @ValueSource(
            strings = {"\"expires\":\"soon\"", "\"expires\":5", "\"roles\":[]", "\"worlds\":[1]"})
    void aFieldThatIsNotAsItShouldBeIsRefused(String field) throws IOException {
        add("ada");
        String known = Files.readString(file);
        String name = field.substring(0, field.indexOf(':'));
        Files.writeString(
                file,
                known.contains(name)
                        ? known.replaceFirst(name + " : \\[[^]]*]", field)
                        : known.replace("\"name\"", field + ",\"name\""));
        assertThatThrownBy(() -> TokenFile.open(file))
                .isInstanceOf(IOException.class)
                .hasMessageContaining("token 1");
    }

    @Test
    void anAddressHasEightAttemptsAndThenOneASecond() throws IOException {
        var attempts = new Attempts();
        InetAddress mallory = InetAddress.getByName("192.0.2.1");
        long now = 5;
        for (int i = 0; i < Attempts.BURST; i++) {
            assertThat(attempts.take(mallory, now)).isTrue();
        }
        assertThat(attempts.take(mallory, now)).isFalse();
        assertThat(attempts.take(InetAddress.getByName("192.0.2.2"), now))
                .as("another address")
                .isTrue();
        now += TimeUnit.SECONDS.toNanos(1);
        assertThat(attempts.take(mallory, now)).isTrue();
        assertThat(attempts.take(mallory, now)).isFalse();
        now += TimeUnit.HOURS.toNanos(1);
        for (int i = 0; i < Attempts.BURST; i++) {
            assertThat(attempts.take(mallory, now)).isTrue();
        }
        assertThat(attempts.take(mallory, now)).as("no more than eight are saved up").isFalse();
    }

    @Test
    void theAddressesOfOneIpv6NetworkCountAsOne() throws IOException {
        var attempts = new Attempts();
        for (int i = 0; i < Attempts.BURST; i++) {
            assertThat(attempts.take(InetAddress.getByName("2001:db8::" + i), 0)).isTrue();
        }
        assertThat(attempts.take(InetAddress.getByName("2001:db8::ffff"), 0)).isFalse();
        assertThat(attempts.take(InetAddress.getByName("2001:db8:0:1::1"), 0)).isTrue();
    }

    @Test
    void aFloodOfAddressesTakesNoMoreThanItsShareOfMemory() throws IOException {
        var attempts = new Attempts();
        List<InetAddress> seen = new ArrayList<>();
        for (int i = 0; i < 2 * Attempts.ADDRESSES; i++) {
            seen.add(
                    InetAddress.getByAddress(
                            new byte[] {10, (byte) (i >> 16), (byte) (i >> 8), (byte) i}));
            for (int j = 0; j < Attempts.BURST; j++) {
                assertThat(attempts.take(seen.getLast(), 0)).isTrue();
            }
        }
        assertThat(attempts.take(seen.getLast(), 0)).as("the last is remembered").isFalse();
        assertThat(attempts.take(seen.getFirst(), 0)).as("the first is forgotten").isTrue();
    }
}
