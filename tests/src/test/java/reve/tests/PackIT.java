// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;

import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.io.OutputStream;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.attribute.FileTime;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Collections;
import java.util.List;
import java.util.stream.Stream;
import java.util.zip.ZipEntry;
import java.util.zip.ZipFile;
import java.util.zip.ZipOutputStream;

/** Worlds in one file, which are packed, moved and run. Also packs that a stranger has prepared. */
@Tag("slow")
class PackIT {
    private static final byte[] WORLD =
            "reve: 1\nname: small\nitems: [{name: one, physics: {mass: 1}}]\n"
                    .getBytes(StandardCharsets.UTF_8);
    private static final int LIST_SIGNATURE = 0x02014b50;

    @TempDir private Path folder;

    @Test
    void aPackedWorldRunsElsewhereToTheSameBits() throws Exception {
        Path world = windy("here");
        Outcome packed = Reve.runAsProcess("pack", world.toString(), "--out", file("a.reve"));
        assertThat(packed.code()).as(packed.err()).isZero();
        assertThat(packed.out()).contains("a.reve: windy, 5 files, ").doesNotContain("--trust");
        assertThat(names(folder.resolve("a.reve")))
                .containsExactly(
                        "expected.json",
                        "laws/wind.law",
                        "models/body.obj",
                        "parts/items.yaml",
                        "world.yaml");
        String before = hash(world.toString());

        Path elsewhere = Files.createDirectory(folder.resolve("elsewhere"));
        Path moved =
                Files.move(folder.resolve("a.reve"), elsewhere.resolve("renamed without ending"));
        remove(world);
        Outcome check = reve("check", moved.toString());
        assertThat(check.code()).as(check.err()).isZero();
        assertThat(check.out()).startsWith(moved + ": valid, 2 items, 2 laws");
        assertThat(hash(moved.toString())).isEqualTo(before);
    }

    /** The pack could not run anywhere. */
    @Test
    void aWorldWhoseLawDoesNotCompileIsNotPacked() throws Exception {
        Path world = windy("here");
        Files.writeString(
                world.resolve("laws/wind.law"), "law wind\n  each body: force += velocty\n");
        Outcome refused = reve("pack", world.toString(), "--out", file("a.reve"));
        assertThat(refused.code()).as(refused.out()).isEqualTo(4);
        assertThat(refused.err()).contains("wind.law:2:23: nothing here is called 'velocty'");
        assertThat(folder.resolve("a.reve")).doesNotExist();
    }

    @Test
    void thePackedWorldIsCheckedAndItsPythonIsCalledPython() throws Exception {
        Path world = Files.createDirectories(folder.resolve("warned/laws")).getParent();
        Files.writeString(
                world.resolve("world.yaml"),
                """
                reve: 1
                name: warned
                constants: {gravity: [0, -9.81, 0]}
                laws: [newton_motion]
                items: [{name: one, physics: {mass: 1, velocity: [1, 0, 0]}}]
                """);
        Outcome packed = reve("pack", world.toString(), "--out", file("a.reve"), "--json");
        assertThat(packed.code()).as(packed.err()).isZero();
        assertThat(packed.err()).contains("world.yaml:3:", "gravity has no effect");
        assertThat(new JsonMapper().readTree(packed.out()).path("warnings").size()).isEqualTo(1);

        Files.writeString(world.resolve("laws/unused.py"), "# a law in Python\n");
        Outcome python = reve("pack", world.toString(), "--out", file("b.reve"));
        assertThat(python.out())
                .contains("; it contains Python, which needs --trust where it runs")
                .doesNotContain("native");
    }

    @Test
    void anExperimentRunsAPackAsItRunsItsWorld() throws Exception {
        Path world = windy("world");
        assertThat(reve("pack", world.toString(), "--out", file("windy.reve")).code()).isZero();
        String experiment =
                """
                experiment: 1
                name: gusts
                world: %s
                seconds: 1
                sweep: {mass: [1 kg, 2 kg]}
                set: {items.two.physics.mass: "{mass} kg"}
                every: 10
                measures: {speed: {of: two, is: norm(physics.velocity)}}
                """;
        Files.writeString(folder.resolve("a.yaml"), experiment.formatted("world/world.yaml"));
        Files.writeString(folder.resolve("b.yaml"), experiment.formatted("windy.reve"));

        Outcome plain = reve("experiment", file("a.yaml"), "--out", file("a"));
        remove(world);
        Outcome packed = reve("experiment", file("b.yaml"), "--out", file("b"));

        assertThat(plain.code()).as(plain.err()).isZero();
        assertThat(packed.code()).as(packed.err()).isZero();
        assertThat(folder.resolve("b/runs.csv"))
                .hasSameTextualContentAs(folder.resolve("a/runs.csv"));
        assertThat(folder.resolve("b/series.csv"))
                .hasSameTextualContentAs(folder.resolve("a/series.csv"));
        assertThat(
                        new JsonMapper()
                                .readTree(Files.readString(folder.resolve("b/result.json")))
                                .path("files")
                                .propertyNames())
                .containsExactly("b.yaml", "windy.reve");
        Outcome again = reve("experiment", file("b.yaml"), "--out", file("b"));
        assertThat(again.out()).contains("identical to the results in ");

        Files.writeString(
                folder.resolve("b.yaml"),
                experiment.replace("two.", "three.").formatted("windy.reve"));
        Outcome mistaken = reve("experiment", file("b.yaml"), "--out", file("c"));
        assertThat(mistaken.code()).isEqualTo(3);
        assertThat(mistaken.err()).contains("items of the world file contain no `three`");
        byte[] cut = Files.readAllBytes(folder.resolve("windy.reve"));
        Files.write(folder.resolve("windy.reve"), Arrays.copyOf(cut, cut.length / 2));
        Outcome damaged = reve("experiment", file("b.yaml"), "--out", file("c"));
        assertThat(damaged.code()).isEqualTo(3);
        assertThat(damaged.err())
                .contains(file("b.yaml") + ":3:8: world: ")
                .contains("windy.reve: is no whole pack");
    }

    @Test
    void theBytesOfAPackDependOnTheFilesOnly() throws Exception {
        Path one = windy("one");
        Path two = windy("two");
        Files.setLastModifiedTime(two.resolve("world.yaml"), FileTime.fromMillis(0));
        Files.writeString(two.resolve("diary.txt"), "not named by the world");
        assertThat(reve("pack", one.toString(), "--out", file("1.reve")).code()).isZero();
        assertThat(reve("pack", two.toString(), "--out", file("2.reve")).code()).isZero();
        assertThat(folder.resolve("1.reve")).hasSameBinaryContentAs(folder.resolve("2.reve"));
    }

    @Test
    void aPackGetsTheLawsOfTheOperatorsFolder() throws Exception {
        Path world = windy("world");
        Path laws = Files.createDirectory(folder.resolve("mine"));
        Files.move(world.resolve("laws/wind.law"), laws.resolve("wind.law"));
        Outcome missing = reve("pack", world.toString(), "--out", file("a.reve"));
        assertThat(missing.code()).isEqualTo(4);
        assertThat(missing.err()).contains("law library 'wind' was not found");
        assertThat(folder.resolve("a.reve")).doesNotExist();
        Outcome packed =
                reve("pack", world.toString(), "--laws", laws.toString(), "--out", file("a.reve"));
        assertThat(packed.code()).as(packed.err()).isZero();
        Outcome check = reve("check", file("a.reve"));
        assertThat(check.code()).as(check.err()).isZero();
    }

    @Test
    void nativeCodeOfAPackNeedsTrust() throws Exception {
        Path world = windy("world");
        Files.writeString(
                world.resolve("world.yaml"),
                Files.readString(world.resolve("world.yaml")).replace("- wind", "- own_drag"));
        Path drag =
                Project.ROOT.resolve("build/current/native/laws/libvesper_law_newton_motion.so");
        Files.copy(drag, world.resolve("laws/libvesper_law_own_drag.so"));
        Outcome packed = reve("pack", world.toString(), "--out", file("a.reve"));
        assertThat(packed.code()).as(packed.err()).isZero();
        assertThat(packed.out()).contains("native code, which needs --trust");
        Outcome run = reve("run", file("a.reve"), "--seconds", "0.1");
        assertThat(run.code()).isEqualTo(4);
        assertThat(run.err()).contains("opened only with --trust");
    }

    @Test
    void problemsNameThePackAndNoTemporaryFolder() throws Exception {
        Path pack = pack("wrong.reve", "world.yaml", "reve: 1\nname: x\nitmes: []\n");
        Outcome check = reve("check", pack.toString());
        assertThat(check.code()).isEqualTo(3);
        assertThat(check.err()).startsWith(pack + "/world.yaml:3:").doesNotContain("reve-pack-");
    }

    @Test
    void theUnpackedFilesAreRemovedAtTheEnd() throws Exception {
        Path temporary = Files.createDirectory(folder.resolve("tmp"));
        assertThat(run(temporary, pack("a.reve", "world.yaml", text()).toString()).code()).isZero();
        assertThat(temporary).isEmptyDirectory();
        Path bad = pack("b.reve", "world.yaml", text(), "a.yaml", "", "A.yaml", "");
        assertThat(run(temporary, bad.toString()).code()).isEqualTo(3);
        assertThat(temporary).isEmptyDirectory();
    }

    @Test
    void hostilePacksAreRefusedAndWriteNothingOutside() throws Exception {
        refused(pack("1.reve", "world.yaml", text(), "../outside", "x"), "within the world's");
        refused(pack("2.reve", "world.yaml", text(), "a/../../outside", "x"), "within the world's");
        refused(pack("3.reve", "world.yaml", text(), "/tmp/outside", "x"), "within the world's");
        refused(pack("4.reve", "world.yaml", text(), "a\\b", "x"), "within the world's");
        refused(pack("5.reve", "world.yaml", text(), "a/b", "x", "A/b", "y"), "are one name");
        refused(pack("6.reve", "world.yaml", text(), "a", "x", "a/b", "y"), "are one name");
        refused(pack("7.reve", "world.yaml", text(), "a".repeat(256), "x"), "has 256 bytes");
    }

    @Test
    void linksAreRefused() throws Exception {
        Path pack = pack("link.reve", "models", "/etc", "world.yaml", text());
        byte[] bytes = Files.readAllBytes(pack);
        ByteBuffer view = ByteBuffer.wrap(bytes).order(ByteOrder.LITTLE_ENDIAN);
        view.putShort(list(view) + 40, (short) 0120777);
        Files.write(pack, bytes);
        refused(pack, "has a link or a special file");
    }

    @Test
    void bombsAreRefused() throws Exception {
        Path bomb = folder.resolve("bomb.reve");
        try (OutputStream out = Files.newOutputStream(bomb);
                ZipOutputStream zip = new ZipOutputStream(out)) {
            zip.putNextEntry(new ZipEntry("world.yaml"));
            zip.write(WORLD);
            zip.putNextEntry(new ZipEntry("zeros.bin"));
            byte[] zeros = new byte[1 << 20];
            for (int mib = 0; mib < 385; mib++) {
                zip.write(zeros);
            }
        }
        assertThat(bomb).satisfies(file -> assertThat(Files.size(file)).isLessThan(1 << 20));
        refused(bomb, "more than 384 MiB together");
        List<String> many = new ArrayList<>(List.of("world.yaml", text()));
        for (int i = 0; i < 4096; i++) {
            many.addAll(List.of("f" + i, ""));
        }
        refused(pack("many.reve", many.toArray(String[]::new)), "has 4097 files, expected at most");
    }

    @Test
    void damagedPacksAreRefused() throws Exception {
        Path pack = pack("a.reve", "world.yaml", text());
        byte[] whole = Files.readAllBytes(pack);
        for (int length : new int[] {0, 4, whole.length / 2, whole.length - 1}) {
            Files.write(pack, Arrays.copyOf(whole, length));
            refused(pack, "is no whole pack");
        }
        byte[] changed = whole.clone();
        view(changed).putInt(list(view(changed)) + 16, 1); // another checksum
        Files.write(pack, changed);
        refused(pack, "is no whole pack");
    }

    @Test
    void whatWouldOutliveTheFolderOfAPackIsRefused() throws Exception {
        Path pack = pack("a.reve", "world.yaml", text());
        Outcome run = reve("run", pack.toString(), "--record", file("run.log"));
        assertThat(run.code()).isEqualTo(2);
        assertThat(run.err()).contains("--record keeps the name of the world's folder", "unzip");
        Outcome again = reve("pack", pack.toString());
        assertThat(again.code()).isEqualTo(2);
        assertThat(again.err()).contains("is a pack already");
    }

    private void refused(Path pack, String reason) throws Exception {
        Outcome check = reve("check", pack.toString());
        assertThat(check.code()).as(pack + ": " + check.err()).isEqualTo(3);
        assertThat(check.err()).startsWith("reve: " + pack + ": ").contains(reason);
        assertThat(check.err().lines()).hasSize(1);
    }

    private static Outcome reve(String... arguments) throws Exception {
        return Reve.run(arguments);
    }

    /** Runs a pack with a temporary folder of its own. */
    private static Outcome run(Path temporary, String pack) throws Exception {
        List<String> command =
                Reve.commandIn(
                        Project.ROOT.resolve("build/current/native"),
                        "run",
                        pack,
                        "--seconds",
                        "0.1");
        command.add(command.indexOf("-cp"), "-Djava.io.tmpdir=" + temporary);
        return Reve.run(command);
    }

    private static String hash(String world) throws Exception {
        Outcome run = reve("run", world, "--seconds", "0.2", "--json");
        assertThat(run.code()).as(run.err()).isZero();
        return new JsonMapper().readTree(run.out()).get("stateHash").asString();
    }

    private String file(String name) {
        return folder.resolve(name).toString();
    }

    private static String text() {
        return new String(WORLD, StandardCharsets.UTF_8);
    }

    /** Writes a zip archive with these names and texts, as any program can. */
    private Path pack(String name, String... files) throws IOException {
        Path pack = folder.resolve(name);
        try (OutputStream out = Files.newOutputStream(pack);
                ZipOutputStream zip = new ZipOutputStream(out)) {
            for (int i = 0; i < files.length; i += 2) {
                zip.putNextEntry(new ZipEntry(files[i]));
                zip.write(files[i + 1].getBytes(StandardCharsets.UTF_8));
            }
        }
        return pack;
    }

    private static ByteBuffer view(byte[] bytes) {
        return ByteBuffer.wrap(bytes).order(ByteOrder.LITTLE_ENDIAN);
    }

    /** Returns the place of the first entry in the list at the end of an archive. */
    private static int list(ByteBuffer archive) {
        int place = 0;
        while (archive.getInt(place) != LIST_SIGNATURE) {
            place++;
        }
        return place;
    }

    private static List<String> names(Path pack) throws IOException {
        try (ZipFile zip = new ZipFile(pack.toFile())) {
            return Collections.list(zip.entries()).stream().map(ZipEntry::getName).toList();
        }
    }

    private static void remove(Path world) throws IOException {
        try (Stream<Path> all = Files.walk(world)) {
            for (Path each : all.sorted(Collections.reverseOrder()).toList()) {
                Files.delete(each);
            }
        }
    }

    /** Writes a world with a law as text, an included file, a mesh and expected results. */
    private Path windy(String name) throws IOException {
        Path world = Files.createDirectory(folder.resolve(name));
        for (String below : List.of("laws", "models", "parts")) {
            Files.createDirectory(world.resolve(below));
        }
        Files.writeString(
                world.resolve("world.yaml"),
                """
                reve: 1
                name: windy
                include: [parts/items.yaml]
                laws:
                  - wind
                  - newton_motion
                items:
                  - name: one
                    physical: {shape: mesh, file: models/body.obj}
                    physics: {mass: 1}
                """);
        Files.writeString(
                world.resolve("parts/items.yaml"),
                """
                items: [{name: two, physics: {mass: 2}}]
                """);
        Files.writeString(world.resolve("models/body.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        Files.writeString(
                world.resolve("laws/wind.law"),
                """
                law wind "Drag towards a uniform wind."
                  parameter c = 2 kg/s, from 0 to 1e6 kg/s
                  parameter w = (5, 0, 0) m/s
                  each body:
                    force += c (w - velocity)
                """);
        Files.writeString(world.resolve("expected.json"), "{}\n");
        return world;
    }
}
