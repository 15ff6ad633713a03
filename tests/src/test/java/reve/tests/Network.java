// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.TimeUnit;

/**
 * A network of the tests: network namespaces that a bridge in a further namespace connects. The JVM
 * of the tests has the address {@link #here} in it. Packets of any member to any other member can
 * be lost, in each direction by itself. The kernel sends no error then, as with a broken cable.
 *
 * <p>Each namespace exists as long as a process {@code cat} that reads from the JVM of the tests.
 * The namespaces and their interfaces therefore disappear with this JVM, even if it is killed.
 * Needs the capabilities CAP_SYS_ADMIN and CAP_NET_ADMIN.
 */
final class Network implements AutoCloseable {
    /** Addresses for tests of networks (RFC 2544), which no other network uses. */
    private static final String PREFIX = "198.18." + (ProcessHandle.current().pid() % 256) + ".";

    private static final int HERE = 254;
    private static final String INTERFACE = "reve" + ProcessHandle.current().pid();

    /** A hardware address that no interface has. Packets to it reach nobody. */
    private static final String NOWHERE = "02:00:00:00:ff:ff";

    private static final long PATIENCE_SECONDS = 300;

    private final List<Process> holders = new ArrayList<>();
    private final List<Member> members = new ArrayList<>();
    private final Process hub;

    /** A machine of the network. */
    record Member(int number, Process holder) {
        /** Returns its IPv4 address. */
        String address() {
            return PREFIX + number;
        }

        /** Returns the words before a command that make it run in this namespace. */
        List<String> entering() {
            return Network.entering(holder);
        }

        private String hardware() {
            return "02:00:00:00:00:%02x".formatted(number);
        }
    }

    /**
     * Creates a network.
     *
     * @param count number of members, 1 to 200
     * @throws IOException if this process may not create namespaces; the message says why
     */
    Network(int count) throws IOException {
        try {
            hub = namespace();
            in(hub, "link", "add", "hub", "type", "bridge", "forward_delay", "0");
            in(hub, "link", "set", "hub", "up");
            for (int number = 1; number <= count; number++) {
                Member member = new Member(number, namespace());
                members.add(member);
                connect(member, "port" + number);
            }
            connectThis();
            for (Member from : members) {
                members.forEach(to -> setNeighbour(from, to, to.hardware()));
            }
        } catch (IOException | RuntimeException refused) {
            close();
            throw refused;
        }
    }

    private Process namespace() throws IOException {
        Process holder =
                new ProcessBuilder("unshare", "--net", "sh", "-c", "echo ready; exec cat")
                        .redirectErrorStream(true)
                        .start();
        holders.add(holder);
        String line = holder.inputReader().readLine();
        if (!"ready".equals(line)) {
            throw new IOException(
                    "no network namespace can be created here (CAP_SYS_ADMIN): " + line);
        }
        return holder;
    }

    private static List<String> entering(Process holder) {
        return List.of("nsenter", "--net=/proc/" + holder.pid() + "/ns/net");
    }

    private void connect(Member member, String port) throws IOException {
        in(
                hub,
                "link",
                "add",
                port,
                "type",
                "veth",
                "peer",
                "name",
                "wire",
                "netns",
                Long.toString(member.holder().pid()));
        in(hub, "link", "set", port, "master", "hub", "up");
        in(member.holder(), "link", "set", "lo", "up");
        in(member.holder(), "link", "set", "wire", "address", member.hardware(), "up");
        in(member.holder(), "address", "add", member.address() + "/24", "dev", "wire");
    }

    private void connectThis() throws IOException {
        in(
                hub,
                "link",
                "add",
                "here",
                "type",
                "veth",
                "peer",
                "name",
                INTERFACE,
                "netns",
                Long.toString(ProcessHandle.current().pid()));
        in(hub, "link", "set", "here", "master", "hub", "up");
        run(List.of("ip", "link", "set", INTERFACE, "up"));
        run(List.of("ip", "address", "add", here() + "/24", "dev", INTERFACE));
    }

    private static void in(Process holder, String... words) throws IOException {
        List<String> command = new ArrayList<>(entering(holder));
        command.add("ip");
        command.addAll(List.of(words));
        run(command);
    }

    private static void run(List<String> command) throws IOException {
        Process process = new ProcessBuilder(command).redirectErrorStream(true).start();
        process.getOutputStream().close();
        String output = new String(process.getInputStream().readAllBytes(), StandardCharsets.UTF_8);
        if (process.onExit().join().exitValue() != 0) {
            throw new IOException(String.join(" ", command) + " failed: " + output.strip());
        }
    }

    private static void setNeighbour(Member from, Member to, String hardware) {
        if (from == to) {
            return;
        }
        try {
            in(
                    from.holder(),
                    "neighbour",
                    "replace",
                    to.address(),
                    "lladdr",
                    hardware,
                    "dev",
                    "wire",
                    "nud",
                    "permanent");
        } catch (IOException e) {
            throw new IllegalStateException(e);
        }
    }

    /** Returns the members, in the order of their numbers. */
    List<Member> members() {
        return List.copyOf(members);
    }

    /** Returns the address of the JVM of the tests. */
    static String here() {
        return PREFIX + HERE;
    }

    /** Loses all packets of a member to another one from now on. */
    void lose(Member from, Member to) {
        setNeighbour(from, to, NOWHERE);
    }

    /** Loses all packets between two members from now on. */
    void separate(Member one, Member other) {
        lose(one, other);
        lose(other, one);
    }

    /** Loses no packets any more. */
    void heal() {
        for (Member from : members) {
            members.forEach(to -> setNeighbour(from, to, to.hardware()));
        }
    }

    /** Returns whether a member gets an answer from another one. */
    boolean reaches(Member from, Member to) throws IOException {
        List<String> command = new ArrayList<>(from.entering());
        // Bash opens a connection; the port is closed, so the other kernel refuses it at once.
        command.addAll(
                List.of(
                        "timeout",
                        "1",
                        "bash",
                        "-c",
                        "exec 3<> /dev/tcp/" + to.address() + "/9 2>&1"));
        Process process = new ProcessBuilder(command).redirectErrorStream(true).start();
        String output = new String(process.getInputStream().readAllBytes(), StandardCharsets.UTF_8);
        int code = process.onExit().join().exitValue();
        if (code != 124 && !output.contains("refused")) {
            throw new AssertionError("found exit code " + code + ": " + output);
        }
        return code != 124;
    }

    /** Removes the network. The programs in its namespaces must have ended. */
    @Override
    public void close() {
        for (Process holder : holders.reversed()) {
            holder.descendants().forEach(ProcessHandle::destroyForcibly);
            holder.destroyForcibly();
            try {
                holder.waitFor(PATIENCE_SECONDS, TimeUnit.SECONDS);
            } catch (InterruptedException e) {
                Thread.currentThread().interrupt();
            }
        }
    }
}
