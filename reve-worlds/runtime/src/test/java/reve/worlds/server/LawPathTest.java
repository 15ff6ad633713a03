// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.pe.PhysicsException;
import reve.pe.Status;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Optional;

/** The names of files that come with a world, in messages. */
class LawPathTest {
    private static final String FORGED = "evil\nfault: forged \u001b[31m";

    @TempDir private Path folder;
    private Path shipped = Path.of("");

    @BeforeEach
    void makeShipped() throws IOException {
        shipped = Files.createDirectory(folder.resolve("shipped"));
        Files.createFile(shipped.resolve("libvesper_law_drag.so"));
    }

    private LawPath pathOfWorld(Path world) {
        return new LawPath(shipped, Optional.empty(), Optional.of(world), false);
    }

    @Test
    void aFileWhoseNameIsNoNameOfALawIsNotListed() throws IOException {
        Path laws = Files.createDirectory(folder.resolve("laws"));
        for (String name :
                new String[] {
                    FORGED + ".law",
                    "libvesper_law_" + FORGED + ".so",
                    FORGED + ".py",
                    "evil\u2028x.law",
                    "a".repeat(48) + ".law",
                    ".law"
                }) {
            Files.createFile(laws.resolve(name));
        }
        Files.createFile(laws.resolve("honest.law"));
        LawPath path = pathOfWorld(folder);
        assertThat(path.names()).containsExactly("drag", "honest");
        assertThatThrownBy(() -> path.find("wicked"))
                .isInstanceOf(PhysicsException.class)
                .hasMessageEndingWith("; known are drag, honest");
    }

    @Test
    void aLawThatLiesElsewhereInTheWorldsFolderIsNamed() throws IOException {
        Files.createFile(folder.resolve("mine.law"));
        Files.createFile(Files.createDirectory(folder.resolve("law")).resolve("other.py"));
        Files.createFile(Files.createDirectory(folder.resolve("laws")).resolve("text.txt"));
        LawPath path = pathOfWorld(folder);
        for (String name : new String[] {"mine", "mine.law"}) {
            assertThatThrownBy(() -> path.find(name))
                    .hasMessageEndingWith(
                            "; the world has the file mine.law: move it into the folder laws/"
                                    + " beside the world file");
        }
        assertThatThrownBy(() -> path.find("other"))
                .hasMessageContaining("; the world has the file law/other.py: move it into ");
        assertThatThrownBy(() -> path.find("text"))
                .hasMessageEndingWith(
                        "; the world has the file laws/text.txt: if it is a law as text, rename it"
                                + " to laws/text.law");
    }

    @Test
    void theReasonForAClientNamesNoFolder() throws IOException {
        Path own = Files.createDirectory(folder.resolve("my laws"));
        LawPath path = new LawPath(shipped, Optional.of(own), Optional.of(folder), false);
        assertThat(reason(path, Status.NOT_FOUND, own + " has no drga"))
                .isEqualTo("no law is called \"drga\"; did you mean `drag`?");
        assertThat(reason(path, Status.LIBRARY_LOAD_FAILED, own + "/drga.so: file too short"))
                .isEqualTo("drga.so: file too short");
        assertThat(reason(path, Status.LIBRARY_LOAD_FAILED, folder + "/laws/drga.so: no N/m"))
                .isEqualTo("laws/drga.so: no N/m");
        assertThat(reason(path, Status.LIBRARY_LOAD_FAILED, "drga.so needs /home/eve/x.so"))
                .isEqualTo(
                        "the library \"drga\" is refused: LIBRARY_LOAD_FAILED; the server's log"
                                + " says why");
    }

    private static String reason(LawPath path, Status status, String message) {
        return path.reasonForClients("drga", new PhysicsException(status, message));
    }

    @Test
    void aLineEndInTheNameOfAFolderIsEscaped() throws IOException {
        Path world = Files.createDirectory(folder.resolve(FORGED));
        Path laws = Files.createDirectory(world.resolve("laws"));
        Files.createFile(laws.resolve("twice.law"));
        Files.createFile(laws.resolve("twice.py"));
        assertThatThrownBy(() -> pathOfWorld(world).find("twice"))
                .isInstanceOf(PhysicsException.class)
                .hasMessageContaining("evil\\u{a}fault: forged \\u{1b}[31m/laws/twice.law")
                .hasMessageNotContaining("\n");
        assertThatThrownBy(() -> LawPath.filesOf(FORGED))
                .isInstanceOf(PhysicsException.class)
                .hasMessageNotContaining("\n");
    }

    @Test
    void aLinkOrFolderInTheOperatorsFolderIsRefusedWithoutBeingRead() throws IOException {
        Path own = Files.createDirectory(folder.resolve("own"));
        Path secret = Files.writeString(folder.resolve("secret"), "law secret");
        Files.createSymbolicLink(own.resolve("linked.law"), secret);
        Files.createSymbolicLink(own.resolve("libvesper_law_zeros.so"), Path.of("/dev/zero"));
        Files.createDirectory(own.resolve("inner.py"));
        LawPath path = new LawPath(shipped, Optional.of(own), Optional.empty(), false);
        for (String name : new String[] {"linked", "zeros", "inner"}) {
            assertThatThrownBy(() -> path.find(name))
                    .isInstanceOf(PhysicsException.class)
                    .hasMessageContaining(own + "/")
                    .hasMessageContaining("expected a regular file, found a ");
        }
    }
}
