// SPDX-License-Identifier: Apache-2.0
package reve.worlds.demo;

import org.jspecify.annotations.Nullable;

import java.io.File;
import java.io.IOException;
import java.net.InetAddress;
import java.net.ServerSocket;
import java.nio.file.DirectoryStream;
import java.nio.file.Files;
import java.nio.file.LinkOption;
import java.nio.file.Path;
import java.nio.file.attribute.PosixFilePermissions;
import java.nio.file.attribute.UserPrincipal;
import java.nio.file.attribute.UserPrincipalNotFoundException;
import java.security.SecureRandom;
import java.util.ArrayList;
import java.util.Comparator;
import java.util.HexFormat;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.TimeUnit;
import java.util.stream.Stream;

/**
 * A PostgreSQL server of the demonstration, in a folder of its own, which is removed at the end. It
 * listens on loopback at a free port, and needs a password. PostgreSQL does not run as root; for
 * root, it runs as the account that its package creates.
 */
final class DemoDatabase implements AutoCloseable {
    private static final String USER = "reve";
    private static final String ACCOUNT = "postgres";
    private static final String DATABASE = "postgres";
    private static final Path PACKAGED = Path.of("/usr/lib/postgresql");
    private static final long PATIENCE_SECONDS = 60;
    private static final long PAUSE_MILLIS = 100;
    private static final int PASSWORD_BYTES = 16;

    private final Path programs;
    private final Optional<UserPrincipal> account;
    private final Path folder;
    private final int port;

    /** Null until the server was started. */
    private @Nullable Process process;

    /**
     * Creates and starts the server, and waits until it answers.
     *
     * @param given folder with the programs of PostgreSQL; if empty, the usual ones are searched
     * @throws IOException if PostgreSQL is not installed or does not start; the message says what
     *     to do
     */
    DemoDatabase(Optional<Path> given) throws IOException, InterruptedException {
        programs = programs(given);
        account = account();
        folder = Files.createTempDirectory("reve-demo-");
        try {
            String password = password();
            Path secret = Files.writeString(folder.resolve("password"), password);
            own(folder);
            own(secret);
            run(
                    "initdb",
                    "--pgdata=" + folder.resolve("data"),
                    "--username=" + USER,
                    "--auth=scram-sha-256",
                    "--pwfile=" + secret,
                    "--encoding=UTF8",
                    "--no-locale",
                    "--no-sync");
            Files.delete(secret);
            port = freePort();
            Path file = folder.resolve("pgpass");
            Files.createFile(
                    file,
                    PosixFilePermissions.asFileAttribute(
                            PosixFilePermissions.fromString("rw-------")));
            Files.writeString(file, "127.0.0.1:" + port + ":*:" + USER + ":" + password + "\n");
            Process server = start();
            process = server;
            await(server);
        } catch (IOException | InterruptedException | RuntimeException failed) {
            close();
            throw failed;
        }
    }

    private static Path programs(Optional<Path> given) throws IOException {
        List<Path> folders = new ArrayList<>();
        if (given.isPresent()) {
            folders.add(given.get());
        } else {
            for (String each : System.getenv().getOrDefault("PATH", "").split(File.pathSeparator)) {
                folders.add(Path.of(each));
            }
            if (Files.isDirectory(PACKAGED)) {
                List<Path> versions = new ArrayList<>();
                try (DirectoryStream<Path> all = Files.newDirectoryStream(PACKAGED)) {
                    all.forEach(version -> versions.add(version.resolve("bin")));
                }
                versions.sort(Comparator.reverseOrder());
                folders.addAll(versions);
            }
        }
        return folders.stream()
                .filter(
                        each ->
                                Stream.of("initdb", "postgres", "pg_isready")
                                        .allMatch(name -> Files.isExecutable(each.resolve(name))))
                .findFirst()
                .orElseThrow(
                        () ->
                                new IOException(
                                        "the demonstration of a cluster starts a PostgreSQL"
                                                + " database of its own, and found no initdb,"
                                                + " postgres and pg_isready in "
                                                + given.map(Path::toString)
                                                        .orElse("PATH and " + PACKAGED)
                                                + "; install PostgreSQL (on Debian: apt-get"
                                                + " install postgresql), or name the folder with"
                                                + " its programs: --postgres DIR"));
    }

    /** Returns the account that runs the server; empty for the account of this process. */
    private static Optional<UserPrincipal> account() throws IOException {
        if (!System.getProperty("user.name").equals("root")) {
            return Optional.empty();
        }
        try {
            return Optional.of(
                    Path.of("/")
                            .getFileSystem()
                            .getUserPrincipalLookupService()
                            .lookupPrincipalByName(ACCOUNT));
        } catch (UserPrincipalNotFoundException none) {
            throw new IOException(
                    "PostgreSQL does not run as root, and this machine has no account "
                            + ACCOUNT
                            + "; run the demonstration as another user",
                    none);
        }
    }

    private void own(Path file) throws IOException {
        if (account.isPresent()) {
            Files.setOwner(file, account.get());
        }
    }

    private static String password() {
        byte[] bytes = new byte[PASSWORD_BYTES];
        new SecureRandom().nextBytes(bytes);
        return HexFormat.of().formatHex(bytes);
    }

    private static int freePort() throws IOException {
        try (ServerSocket socket = new ServerSocket(0, 1, InetAddress.getLoopbackAddress())) {
            return socket.getLocalPort();
        }
    }

    private List<String> command(String program, String... arguments) {
        List<String> command = new ArrayList<>();
        if (account.isPresent()) {
            command.addAll(
                    List.of(
                            "setpriv",
                            "--reuid=" + ACCOUNT,
                            "--regid=" + ACCOUNT,
                            "--clear-groups"));
        }
        command.add(programs.resolve(program).toString());
        command.addAll(List.of(arguments));
        return command;
    }

    private void run(String program, String... arguments) throws IOException, InterruptedException {
        Process running =
                new ProcessBuilder(command(program, arguments)).redirectErrorStream(true).start();
        String output = new String(running.getInputStream().readAllBytes());
        if (running.waitFor() != 0) {
            throw new IOException(programs.resolve(program) + " failed: " + output.strip());
        }
    }

    private Process start() throws IOException {
        return new ProcessBuilder(
                        command(
                                "postgres",
                                "-D",
                                folder.resolve("data").toString(),
                                "-p",
                                Integer.toString(port),
                                "-c",
                                "listen_addresses=127.0.0.1",
                                "-c",
                                "unix_socket_directories="))
                .redirectErrorStream(true)
                .redirectOutput(folder.resolve("log").toFile())
                .start();
    }

    private void await(Process server) throws IOException, InterruptedException {
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(PATIENCE_SECONDS);
        List<String> asks = command("pg_isready", "-q", "-h", "127.0.0.1", "-p", port + "");
        while (new ProcessBuilder(asks).start().waitFor() != 0) {
            if (!server.isAlive() || System.nanoTime() > end) {
                throw new IOException(
                        "PostgreSQL does not start: "
                                + Files.readString(folder.resolve("log")).strip());
            }
            Thread.sleep(PAUSE_MILLIS);
        }
    }

    /** Returns the URL of the database, as {@code --store} takes it. */
    String url() {
        return "postgresql://" + USER + "@127.0.0.1:" + port + "/" + DATABASE;
    }

    /** Returns the variables by which a program finds the password. */
    Map<String, String> environment() {
        return Map.of("PGPASSFILE", folder.resolve("pgpass").toString());
    }

    private void remove() throws IOException {
        try (Stream<Path> files = Files.walk(folder)) {
            for (Path file : files.sorted(Comparator.reverseOrder()).toList()) {
                if (Files.exists(file, LinkOption.NOFOLLOW_LINKS)) {
                    Files.delete(file);
                }
            }
        }
    }

    /** Ends the server at once, and removes its folder. Idempotent. */
    @Override
    public void close() throws IOException {
        Process server = process;
        if (server != null) {
            server.descendants().forEach(ProcessHandle::destroyForcibly);
            server.destroyForcibly();
            server.onExit().join();
        }
        if (Files.exists(folder)) {
            remove();
        }
    }
}
