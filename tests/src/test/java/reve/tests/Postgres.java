// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import java.io.IOException;
import java.net.InetAddress;
import java.net.ServerSocket;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.sql.Connection;
import java.sql.DriverManager;
import java.sql.ResultSet;
import java.sql.SQLException;
import java.sql.Statement;
import java.util.ArrayList;
import java.util.Comparator;
import java.util.List;
import java.util.concurrent.TimeUnit;
import java.util.stream.Stream;

/**
 * A PostgreSQL server of the tests. It has a folder of its own, and listens on loopback or on the
 * address of a member of a {@link Network}. PostgreSQL does not run as root; for root, it runs as
 * the account that its package creates. Closing it ends the server and removes the folder.
 */
final class Postgres implements AutoCloseable {
    private static final String USER = "reve";
    private static final String ACCOUNT = "postgres";
    private static final Path PROGRAMS = Path.of("/usr/lib/postgresql");
    private static final long PATIENCE_SECONDS = 60;
    private static final int TRIES = 5;

    /** A node needs two connections for each world that it runs. */
    private static final int MOST_CONNECTIONS = 200;

    private static final String LOOPBACK = "127.0.0.1";
    private static final int PORT = 5432;

    private final Path folder;
    private final List<String> entering;
    private final String host;
    private final int port;
    private final Thread atExit = new Thread(this::kill);
    private Process process;

    /** Creates a server with an empty database cluster, and waits until it answers. */
    Postgres() throws IOException {
        this(List.of(), LOOPBACK);
    }

    /** Creates a server in a network namespace, which trusts all members of the network. */
    Postgres(Network.Member at) throws IOException {
        this(at.entering(), at.address());
    }

    private Postgres(List<String> entering, String host) throws IOException {
        this.entering = entering;
        this.host = host;
        folder = Files.createTempDirectory("reve-postgres-");
        if (isRoot()) {
            Files.setOwner(
                    folder,
                    folder.getFileSystem()
                            .getUserPrincipalLookupService()
                            .lookupPrincipalByName(ACCOUNT));
        }
        run(
                List.of(
                        program("initdb"),
                        "--pgdata=" + data(),
                        "--username=" + USER,
                        "--auth=trust",
                        "--encoding=UTF8",
                        "--no-locale",
                        "--no-sync"));
        Runtime.getRuntime().addShutdownHook(atExit);
        if (entering.isEmpty()) {
            port = startAtFreePort();
        } else {
            Files.writeString(
                    data().resolve("pg_hba.conf"),
                    "host all all samenet trust" + System.lineSeparator(),
                    StandardOpenOption.APPEND);
            port = PORT; // the namespace has no other server
            start(port);
        }
    }

    private static boolean isRoot() {
        return System.getProperty("user.name").equals("root");
    }

    private static String program(String name) throws IOException {
        try (Stream<Path> versions = Files.list(PROGRAMS)) {
            return versions.map(version -> version.resolve("bin").resolve(name))
                    .filter(Files::isExecutable)
                    .max(Comparator.naturalOrder())
                    .orElseThrow()
                    .toString();
        }
    }

    private Path data() {
        return folder.resolve("data");
    }

    private static ProcessBuilder command(List<String> words) {
        return command(List.of(), words);
    }

    private static ProcessBuilder command(List<String> entering, List<String> words) {
        List<String> command = new ArrayList<>(entering);
        if (isRoot()) {
            command.addAll(
                    List.of(
                            "setpriv",
                            "--reuid=" + ACCOUNT,
                            "--regid=" + ACCOUNT,
                            "--clear-groups"));
        }
        command.addAll(words);
        return new ProcessBuilder(command).redirectErrorStream(true);
    }

    private static void run(List<String> words) throws IOException {
        Process process = command(words).start();
        String output = new String(process.getInputStream().readAllBytes());
        if (process.onExit().join().exitValue() != 0) {
            throw new AssertionError(words + " failed: " + output);
        }
    }

    /**
     * Starts the server at a free port. Another program may take the port before the server does,
     * so tries again.
     */
    private int startAtFreePort() throws IOException {
        for (int attempt = 1; ; attempt++) {
            int free;
            try (ServerSocket socket = new ServerSocket(0, 1, InetAddress.getLoopbackAddress())) {
                free = socket.getLocalPort();
            }
            try {
                start(free);
                return free;
            } catch (AssertionError taken) {
                if (attempt == TRIES) {
                    throw taken;
                }
            }
        }
    }

    private void start(int at) throws IOException {
        Path log = folder.resolve("log");
        process =
                command(
                                entering,
                                List.of(
                                        program("postgres"),
                                        "-D",
                                        data().toString(),
                                        "-p",
                                        Integer.toString(at),
                                        "-c",
                                        "listen_addresses=" + host,
                                        "-c",
                                        "max_connections=" + MOST_CONNECTIONS,
                                        "-c",
                                        "fsync=off", // the machine does not end
                                        "-c",
                                        "unix_socket_directories=" + folder))
                        .redirectOutput(log.toFile())
                        .start();
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(PATIENCE_SECONDS);
        while (true) {
            try {
                connect(at, "postgres").close();
                return;
            } catch (SQLException notYet) {
                if (!process.isAlive() || System.nanoTime() > end) {
                    throw new AssertionError(Files.readString(log), notYet);
                }
                Thread.onSpinWait();
            }
        }
    }

    /** Starts the server again at its port. */
    void start() throws IOException {
        start(port);
    }

    /** Ends the server at once: connections break, and it recovers at the next start. */
    void stop() throws IOException {
        run(List.of(program("pg_ctl"), "--pgdata=" + data(), "--mode=immediate", "--wait", "stop"));
        process.onExit().join();
    }

    /** Returns the URL of a database, as {@code --store} takes it. */
    String url(String database) {
        return "postgresql://"
                + USER
                + "@"
                + host
                + ":"
                + port
                + "/"
                + database
                + (entering.isEmpty() ? "" : "?sslmode=disable");
    }

    /** Creates an empty database and returns its URL. */
    String create(String database) throws SQLException {
        try (Connection connection = connect(port, "postgres");
                Statement statement = connection.createStatement()) {
            statement.execute("CREATE DATABASE " + database);
        }
        return url(database);
    }

    private Connection connect(int at, String database) throws SQLException {
        return DriverManager.getConnection(
                "jdbc:postgresql://" + host + ":" + at + "/" + database + "?user=" + USER);
    }

    Connection connect(String database) throws SQLException {
        return connect(port, database);
    }

    /** Executes a statement in a database. */
    void execute(String database, String sql) throws SQLException {
        try (Connection connection = connect(port, database);
                Statement statement = connection.createStatement()) {
            statement.execute(sql);
        }
    }

    /** Returns the rows of a query, with commas between the columns. */
    List<String> query(String database, String sql) throws SQLException {
        List<String> found = new ArrayList<>();
        try (Connection connection = connect(port, database);
                Statement statement = connection.createStatement();
                ResultSet rows = statement.executeQuery(sql)) {
            int columns = rows.getMetaData().getColumnCount();
            while (rows.next()) {
                List<String> row = new ArrayList<>();
                for (int i = 1; i <= columns; i++) {
                    row.add(rows.getString(i));
                }
                found.add(String.join(",", row));
            }
        }
        return found;
    }

    private void kill() {
        if (process != null) {
            process.descendants().forEach(ProcessHandle::destroyForcibly);
            process.destroyForcibly();
        }
    }

    @Override
    public void close() throws IOException {
        Runtime.getRuntime().removeShutdownHook(atExit);
        if (process.isAlive()) {
            stop();
        }
        try (Stream<Path> files = Files.walk(folder)) {
            for (Path file : files.sorted(Comparator.reverseOrder()).toList()) {
                Files.delete(file);
            }
        }
    }
}
