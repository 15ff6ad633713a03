// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.jspecify.annotations.Nullable;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;
import picocli.CommandLine.Spec;

import reve.core.agent.auth.AgentToken;
import reve.core.agent.auth.Rights;
import reve.core.agent.auth.TokenFile;
import reve.core.agent.protocol.Role;
import reve.core.disk.Reason;
import reve.worlds.Product;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.channels.FileChannel;
import java.nio.charset.StandardCharsets;
import java.nio.file.FileAlreadyExistsException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.nio.file.attribute.PosixFilePermissions;
import java.time.Duration;
import java.time.Instant;
import java.time.format.DateTimeParseException;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.TreeSet;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/** The command {@code token}: creates, lists and revokes the tokens that authenticate clients. */
@Command(
        name = "token",
        description = "Creates, lists and revokes the tokens that authenticate clients.")
public final class TokenCommand implements Runnable {
    private static final Pattern TIME_TO_LIVE = Pattern.compile("(\\d{1,6})([hd])");

    /** The options that limit the rights of a token. */
    static final class RightsOptions {
        @Option(
                names = "--roles",
                paramLabel = "ROLE",
                split = ",",
                defaultValue = "agent",
                description = "Roles: agent, control, observer (default: ${DEFAULT-VALUE}).")
        private List<Role> roles = List.of();

        @Option(
                names = "--worlds",
                paramLabel = "NAME",
                split = ",",
                description = "Permit only these worlds (default: all).")
        private @Nullable List<String> worlds;

        @Option(
                names = "--bodies",
                paramLabel = "ITEM",
                split = ",",
                description = "Permit only these bodies (default: all).")
        private @Nullable List<String> bodies;

        @Option(
                names = "--capabilities",
                paramLabel = "NAME",
                split = ",",
                description = "Permit only these capabilities of the body (default: all).")
        private @Nullable List<String> capabilities;

        @Option(
                names = "--lock-step",
                description = "Permit lock-step: the world waits for the agent.")
        private boolean lockStep;

        @Option(
                names = "--laws",
                paramLabel = "LAW[.PARAMETER]",
                split = ",",
                description =
                        "With the role control, permit only changes of these laws, or of single"
                                + " parameters, such as wind.c (default: all control commands).")
        private @Nullable List<String> laws;

        Rights rights() {
            return new Rights(
                    Set.copyOf(roles),
                    names(worlds),
                    names(bodies),
                    names(capabilities),
                    lockStep,
                    names(laws));
        }

        private static Optional<Set<String>> names(@Nullable List<String> given) {
            return Optional.ofNullable(given).map(Set::copyOf);
        }
    }

    @Spec private CommandSpec spec = CommandSpec.create();

    @Override
    public void run() {
        throw new ParameterException(spec.commandLine(), "expected one of new, list, revoke");
    }

    @Command(
            name = "new",
            description =
                    "Adds a token to the file and prints it. The file contains only its hash.")
    int issue(
            @Parameters(
                            paramLabel = "NAME",
                            description = "Client name, as in the field name of hello.")
                    String name,
            @Option(
                            names = "--file",
                            paramLabel = "FILE",
                            defaultValue = "tokens.json",
                            description =
                                    "Token file, created if missing "
                                            + "(default: ${DEFAULT-VALUE}).")
                    Path file,
            @Mixin RightsOptions rights,
            @Option(
                            names = "--expires",
                            paramLabel = "WHEN",
                            description =
                                    "Expiry: 30d, 12h, or a time such as 2030-01-31T12:00:00Z.")
                    Optional<String> expires,
            @Option(
                            names = "--out",
                            paramLabel = "FILE",
                            description =
                                    "Write the token to a new file that only its owner may read "
                                            + "(mode 600), instead of printing it.")
                    Optional<Path> out,
            @Option(names = "--json", description = "Print the result as one JSON document.")
                    boolean json)
            throws IOException {
        AgentToken.Issued issued;
        try {
            issued = AgentToken.issue(name, rights.rights(), expires.map(TokenCommand::instant));
        } catch (IllegalArgumentException e) {
            throw new ParameterException(spec.subcommands().get("new"), e.getMessage());
        }
        if (out.isPresent()) {
            write(out.get(), issued.secret());
        }
        try {
            TokenFile.add(file, issued.token());
        } catch (IOException e) {
            if (out.isPresent()) {
                Files.delete(out.get());
            }
            throw e;
        }
        if (json) {
            Map<String, Object> fields = new LinkedHashMap<>();
            out.ifPresentOrElse(
                    path -> fields.put("out", path.toString()),
                    () -> fields.put("token", issued.secret()));
            fields.putAll(fields(issued.token()));
            Json.print(spec, fields);
        } else if (out.isPresent()) {
            spec.commandLine()
                    .getErr()
                    .println(
                            "reve: the token of "
                                    + name
                                    + " is in "
                                    + out.get()
                                    + " only; "
                                    + file
                                    + " keeps its hash");
        } else {
            spec.commandLine()
                    .getErr()
                    .println(
                            "reve: this token of "
                                    + name
                                    + " is shown only now; "
                                    + file
                                    + " keeps its hash");
            spec.commandLine().getOut().println(issued.secret());
        }
        return ExitCode.OK;
    }

    private void write(Path out, String secret) throws IOException {
        Path path =
                WritableFile.require(spec.subcommands().get("new").getCommandSpec(), "--out", out);
        try (FileChannel file =
                FileChannel.open(
                        path,
                        Set.of(StandardOpenOption.CREATE_NEW, StandardOpenOption.WRITE),
                        PosixFilePermissions.asFileAttribute(
                                PosixFilePermissions.fromString("rw-------")))) {
            file.write(ByteBuffer.wrap((secret + "\n").getBytes(StandardCharsets.US_ASCII)));
        } catch (FileAlreadyExistsException e) {
            throw new IOException(
                    "--out " + out + " is there already; name another file, or remove it", e);
        } catch (IOException e) {
            Files.deleteIfExists(path);
            throw Reason.naming(path, e);
        }
    }

    @Command(
            name = "list",
            description = "Lists the names, rights and expiry of the tokens in a file.")
    int list(
            @Option(
                            names = "--file",
                            paramLabel = "FILE",
                            defaultValue = "tokens.json",
                            description = "Token file (default: ${DEFAULT-VALUE}).")
                    Path file,
            @Option(names = "--json", description = "Print the result as one JSON document.")
                    boolean json)
            throws IOException {
        List<Map<String, Object>> tokens = new ArrayList<>();
        for (AgentToken token : TokenFile.open(file).tokens()) {
            tokens.add(fields(token));
        }
        if (json) {
            Json.print(spec, Map.of("tokens", tokens));
        } else {
            tokens.forEach(fields -> spec.commandLine().getOut().println(line(fields)));
        }
        return ExitCode.OK;
    }

    @Command(
            name = "revoke",
            description =
                    "Removes tokens from a file. Servers disconnect the clients that "
                            + "used them.")
    int revoke(
            @Parameters(
                            paramLabel = "NAME|ID",
                            description =
                                    "Client name, to remove all its tokens, or id of one token.")
                    String nameOrId,
            @Option(
                            names = "--file",
                            paramLabel = "FILE",
                            defaultValue = "tokens.json",
                            description = "Token file (default: ${DEFAULT-VALUE}).")
                    Path file)
            throws IOException {
        List<AgentToken> revoked = TokenFile.revoke(file, nameOrId);
        if (revoked.isEmpty()) {
            spec.commandLine()
                    .getErr()
                    .println(
                            "reve: "
                                    + file
                                    + " has no token of the name or id "
                                    + nameOrId
                                    + "; "
                                    + Product.command()
                                    + " token list --file "
                                    + file
                                    + " shows those that it has");
            return ExitCode.FAILURE;
        }
        revoked.forEach(
                token -> spec.commandLine().getOut().println("revoked " + line(fields(token))));
        return ExitCode.OK;
    }

    private static Instant instant(String when) {
        Instant now = Instant.now();
        Instant end;
        Matcher time = TIME_TO_LIVE.matcher(when);
        if (time.matches()) {
            int count = Integer.parseInt(time.group(1));
            end =
                    now.plus(
                            time.group(2).equals("d")
                                    ? Duration.ofDays(count)
                                    : Duration.ofHours(count));
        } else {
            try {
                end = Instant.parse(when);
            } catch (DateTimeParseException e) {
                throw new IllegalArgumentException(
                        "--expires "
                                + when
                                + ": expected 30d, 12h, or a time such as 2030-01-31T12:00:00Z",
                        e);
            }
        }
        if (!end.isAfter(now)) {
            throw new IllegalArgumentException(
                    "--expires " + when + " is over already, expected a time to come");
        }
        return end;
    }

    private static Map<String, Object> fields(AgentToken token) {
        Rights rights = token.rights();
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("id", token.id());
        fields.put("name", token.name());
        fields.put("roles", rights.roles().stream().sorted().map(Role::wireName).toList());
        rights.worlds().ifPresent(names -> fields.put("worlds", new TreeSet<>(names)));
        rights.bodies().ifPresent(names -> fields.put("bodies", new TreeSet<>(names)));
        rights.capabilities().ifPresent(names -> fields.put("capabilities", new TreeSet<>(names)));
        if (rights.lockStep()) {
            fields.put("lockStep", true);
        }
        rights.laws().ifPresent(names -> fields.put("laws", new TreeSet<>(names)));
        token.expires().ifPresent(time -> fields.put("expires", time.toString()));
        if (token.hasExpired(Instant.now())) {
            fields.put("expired", true);
        }
        return fields;
    }

    private static String line(Map<String, Object> fields) {
        var line =
                new StringBuilder(
                        String.format(Locale.ROOT, "%s %s", fields.get("id"), fields.get("name")));
        fields.forEach(
                (field, value) -> {
                    if (!field.equals("id") && !field.equals("name")) {
                        line.append(' ').append(field).append('=').append(value);
                    }
                });
        return line.toString();
    }
}
