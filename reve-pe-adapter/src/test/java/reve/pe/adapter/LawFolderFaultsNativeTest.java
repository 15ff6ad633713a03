// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.core.world.WorldEvent;
import reve.pe.NativeFiles;
import reve.pe.PhysicsLaw;

import java.io.IOException;
import java.io.UncheckedIOException;
import java.net.StandardProtocolFamily;
import java.net.UnixDomainSocketAddress;
import java.nio.ByteBuffer;
import java.nio.channels.FileChannel;
import java.nio.channels.ServerSocketChannel;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.TreeMap;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.locks.LockSupport;

/**
 * Files in a laws folder that are no laws, or that are not yet complete. Each causes one event, and
 * no frame is lost. The frames of the world are compared with those of a world without a folder.
 */
@Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
class LawFolderFaultsNativeTest {
    private static final int MACHINE = 18; // place of e_machine in the header of an ELF file
    private static final int X86_64 = 62;
    private static final int AARCH64 = 183;

    @TempDir private Path parent;
    private final AdapterFixture world = HostedFixture.inProcess();
    private final AdapterFixture alone = HostedFixture.inProcess();
    private Path folder;
    private LawFolder laws;
    private long frames;

    @BeforeEach
    void follow() throws IOException {
        folder = Files.createDirectory(parent.resolve("laws"));
        world.load("newton_motion");
        alone.load("newton_motion");
        laws =
                new LawFolder(
                        LawFolder.ORIGIN,
                        folder,
                        world.engine,
                        world.adapter.laws(),
                        world.commands,
                        (library, file) -> FolderParameters.NONE);
    }

    @AfterEach
    void close() {
        laws.close();
        world.close();
        alone.close();
    }

    /** Makes a frame in both worlds. */
    private void frame() {
        world.run(1);
        alone.run(1);
        frames++;
    }

    private void lookAndRun(int times) {
        for (int i = 0; i < times; i++) {
            laws.look();
            frame();
        }
    }

    private List<String> loaded() {
        return world.adapter.laws().loaded().stream().map(PhysicsLaw::name).toList();
    }

    private static byte[] wind() throws IOException {
        return Files.readAllBytes(NativeFiles.testLaw("wind"));
    }

    /** Returns the law for the other processor: only its header differs. */
    private static byte[] forAnotherProcessor() throws IOException {
        byte[] bytes = wind();
        bytes[MACHINE] = (byte) (bytes[MACHINE] == X86_64 ? AARCH64 : X86_64);
        return bytes;
    }

    private static byte[] with(int place, int value) throws IOException {
        byte[] bytes = wind();
        bytes[place] = (byte) value;
        return bytes;
    }

    /** The messages of the faults by file; fails if a file has two. */
    private Map<String, String> messages() {
        Map<String, String> messages = new TreeMap<>();
        for (WorldEvent fault : world.events("fault")) {
            String file = String.valueOf(fault.fields().get("file"));
            assertThat(messages).as("one line each").doesNotContainKey(file);
            messages.put(file, String.valueOf(fault.fields().get("message")));
        }
        return messages;
    }

    /**
     * The folder's own thread follows its files. If this thread waited for the other end of a pipe,
     * it would never report the files after the pipe.
     */
    @Test
    void filesThatAreNoLawsCostOneEventEachAndNoFrame() throws Exception {
        Files.write(folder.resolve("a-arm.so"), forAnotherProcessor());
        Files.write(folder.resolve("b-32-bit.so"), with(4, 1));
        Files.write(folder.resolve("c-big-endian.so"), with(5, 2));
        Files.write(folder.resolve("d-half.so"), Arrays.copyOf(wind(), wind().length / 2));
        Files.createSymbolicLink(folder.resolve("e-link.so"), NativeFiles.testLaw("wind"));
        Files.createSymbolicLink(folder.resolve("f-dangling.so"), folder.resolve("nowhere"));
        for (String pipe : List.of("g-pipe.so", "g-pipe.law", "g-pipe.py")) {
            Path file = folder.resolve(pipe);
            assertThat(new ProcessBuilder("mkfifo", file.toString()).start().waitFor()).isZero();
        }
        Files.createDirectory(folder.resolve("h-folder.so"));
        Files.write(folder.resolve("z-wind.so"), wind());
        try (ServerSocketChannel socket = ServerSocketChannel.open(StandardProtocolFamily.UNIX)) {
            socket.bind(UnixDomainSocketAddress.of(folder.resolve("i-socket.so")));
            laws.start();
            while (messages().size() < 11 || loaded().size() < 2) {
                Thread.sleep(5);
                world.run(1);
                frames++;
            }
        }
        for (int i = 0; i < 50; i++) { // several scans more report nothing again
            Thread.sleep(20);
            world.run(1);
            frames++;
        }
        assertThat(messages().values())
                .satisfiesExactly(
                        arm -> assertThat(arm).contains("ELF file for another processor"),
                        small -> assertThat(small).contains("not a 64-bit ELF file"),
                        big -> assertThat(big).contains("ELF file of another byte order"),
                        half -> assertThat(half).contains("truncated: needs "),
                        link -> assertThat(link).contains("found a symbolic link"),
                        dangling -> assertThat(dangling).contains("found a symbolic link"),
                        pipe -> assertThat(pipe).contains("found a special file"),
                        pipe -> assertThat(pipe).contains("found a special file"),
                        pipe -> assertThat(pipe).contains("found a special file"),
                        inside -> assertThat(inside).contains("found a folder"),
                        socket -> assertThat(socket).contains("found a special file"));
        assertThat(messages().values()).noneMatch(message -> message.contains("\n"));
        assertThat(loaded()).containsExactly("newton_motion", "wind");
        assertThat(world.loop.frame()).isEqualTo(frames);
    }

    /**
     * A scan follows after each 205 bytes. This is the case at 1 kB/s with five scans per second.
     */
    @Test
    void aCopyAtAKilobyteASecondIsOpenedOnceItIsWhole() throws Exception {
        byte[] whole = wind();
        Path file = Files.createFile(folder.resolve("wind.so"));
        for (int done = 0; done < whole.length; done += 205) {
            Files.write(
                    file,
                    Arrays.copyOfRange(whole, done, Math.min(whole.length, done + 205)),
                    StandardOpenOption.APPEND);
            lookAndRun(1);
            assertThat(Files.readString(Path.of("/proc/self/maps"))).doesNotContain("wind.so");
        }
        assertThat(world.adapter.stateHash()).isEqualTo(alone.adapter.stateHash());
        lookAndRun(2);
        assertThat(loaded()).containsExactly("newton_motion", "wind");
        assertThat(world.events("fault")).isEmpty();
        assertThat(world.events("law-loaded")).hasSize(2);
    }

    /**
     * After a pause, the scans see a part of a file that no longer grows. Its headers show that it
     * is not complete.
     */
    @Test
    void aCopyThatPausesIsNeverOpenedInPart() throws Exception {
        byte[] whole = wind();
        for (int part = 1; part < 16; part++) {
            Files.write(folder.resolve("wind.so"), Arrays.copyOf(whole, whole.length * part / 16));
            lookAndRun(4);
            assertThat(loaded()).containsExactly("newton_motion");
            assertThat(Files.readString(Path.of("/proc/self/maps"))).doesNotContain("wind.so");
        }
        assertThat(world.events("fault")).as("not told before it waits for long").isEmpty();
        assertThat(world.adapter.stateHash()).isEqualTo(alone.adapter.stateHash());
        Files.write(folder.resolve("wind.so"), whole);
        lookAndRun(2);
        assertThat(loaded()).containsExactly("newton_motion", "wind");
    }

    /** Number of times at which the file changes. */
    private static final int OVERWRITES = 1_000;

    /** The file keeps its inode. Therefore a process that mapped the file would end by SIGBUS. */
    @Test
    void aFileThatIsTruncatedAndOverwrittenWhileItsLawActsChangesNoFrame() throws Exception {
        byte[] whole = wind();
        byte[] other = Files.readAllBytes(NativeFiles.testLaw("strong_wind"));
        Path file = folder.resolve("wind.so");
        Files.write(file, whole);
        while (!loaded().contains("wind")) {
            laws.look();
            world.run(1);
            if (loaded().contains("wind")) {
                alone.load("wind");
            }
            alone.run(1);
        }
        Random random = new Random(1902);
        try (FileChannel open = FileChannel.open(file, StandardOpenOption.WRITE)) {
            for (int change = 0; change < OVERWRITES; change++) {
                if (change % 3 == 2) {
                    open.write(ByteBuffer.wrap(whole), 0);
                } else {
                    int left = random.nextInt(whole.length * 3 / 4);
                    open.truncate(left);
                    open.write(ByteBuffer.wrap(other, 0, random.nextInt(left + 1)), 0);
                }
                lookAndRun(1);
                assertThat(world.adapter.stateHash())
                        .as("after change " + change)
                        .isEqualTo(alone.adapter.stateHash());
            }
            open.truncate(0);
            open.write(ByteBuffer.wrap(other), 0);
        }
        lookAndRun(4);
        assertThat(world.adapter.stateHash())
                .as("the complete new version acts")
                .isNotEqualTo(alone.adapter.stateHash());
        assertThat(loaded()).containsExactly("newton_motion", "wind");
        assertThat(world.events("fault")).isEmpty();
    }

    @Test
    void aFolderThatIsRemovedAndMadeAgainIsFollowedAgain() throws Exception {
        Files.write(folder.resolve("wind.so"), wind());
        lookAndRun(3);
        assertThat(loaded()).containsExactly("newton_motion", "wind");
        Files.delete(folder.resolve("wind.so"));
        Files.delete(folder);
        lookAndRun(3);
        assertThat(loaded()).as("laws stay without a folder").contains("wind");
        Files.createDirectory(folder);
        Files.write(folder.resolve("wind.so"), wind());
        lookAndRun(3);
        assertThat(world.events("law-loaded")).as("the same law acts on").hasSize(2);
        assertThat(world.events("law-unloaded")).isEmpty();
        Files.delete(folder.resolve("wind.so"));
        Files.delete(folder);
        lookAndRun(3);
        Files.createDirectory(folder);
        lookAndRun(2);
        assertThat(loaded()).as("the new folder is empty").containsExactly("newton_motion");
        Files.write(folder.resolve("strong.so"), Files.readAllBytes(NativeFiles.testLaw("gale")));
        lookAndRun(2);
        assertThat(loaded()).hasSize(2);
        assertThat(world.events("fault")).isEmpty();
        assertThat(world.loop.frame()).isEqualTo(frames);
    }

    /** Number of files in the storm. The fault model requires 10,000. */
    private static final int STORM_FILES = Integer.getInteger("reve.test.storm.files", 400);

    /** Time after the storm in which the last file must act; 5 s on an idle machine [s]. */
    private static final int CALM_SECONDS = Integer.getInteger("reve.test.storm.seconds", 600);

    /** Least frame rate as a percentage of the rate before the storm; 95 on an idle machine. */
    private static final int LEAST_PERCENT = Integer.getInteger("reve.test.storm.percent", 20);

    /** Number of storms of which one must have the least frame rate: a busy machine may pause. */
    private static final int STORMS = 3;

    private static final int FILES_PER_MILLISECOND = 2; // each file is written and removed

    @Test
    void aStormOfFilesDelaysNoFrameAndTheLastFileActs() throws Exception {
        laws.start();
        Ticks ticks = new Ticks();
        double percent = 0;
        for (int i = 0; i < STORMS && percent <= LEAST_PERCENT; i++) {
            double before = 60 * ticks.second(world);
            percent = 100 * framesPerSecondOfAStorm(ticks) / before;
        }
        assertThat(percent).as("% of the frame rate").isGreaterThan(LEAST_PERCENT);
        Files.write(folder.resolve("wind.so"), wind());
        long calm = System.nanoTime();
        while (!loaded().equals(List.of("newton_motion", "wind"))) {
            ticks.run(world);
            assertThat((System.nanoTime() - calm) / 1e9).isLessThan(CALM_SECONDS);
        }
    }

    private double framesPerSecondOfAStorm(Ticks ticks) throws Exception {
        CompletableFuture<Void> storm =
                CompletableFuture.runAsync(
                        () -> {
                            for (boolean write : new boolean[] {true, false}) {
                                storm(write);
                            }
                        },
                        task -> Thread.ofPlatform().daemon().start(task));
        long start = System.nanoTime();
        long made = 0;
        while (!storm.isDone()) {
            ticks.run(world);
            made++;
        }
        storm.get();
        return made / ((System.nanoTime() - start) / 1e9);
    }

    private void storm(boolean write) {
        for (int i = 0; i < STORM_FILES; i++) {
            Path file = folder.resolve("storm_" + i + ".law");
            try {
                if (write) {
                    Files.writeString(
                            file, "law storm_" + i + "\n  each body: force += 1 N (0, 1, 0)\n");
                } else {
                    Files.delete(file);
                }
            } catch (IOException e) {
                throw new UncheckedIOException(e);
            }
            if (i % FILES_PER_MILLISECOND == 0) {
                LockSupport.parkNanos(1_000_000);
            }
        }
    }
}
