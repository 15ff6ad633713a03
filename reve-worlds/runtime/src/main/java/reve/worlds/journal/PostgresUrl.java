// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import java.net.URI;
import java.net.URISyntaxException;
import java.net.URLDecoder;
import java.net.URLEncoder;
import java.nio.charset.StandardCharsets;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Properties;
import java.util.Set;

/**
 * The address of a PostgreSQL database, for example {@code postgresql://ada@host:5432/worlds}. It
 * contains no password. The driver reads passwords from the file {@code ~/.pgpass}, or from the
 * file that the environment variable {@code PGPASSFILE} names.
 *
 * @param host name or address; an IPv6 address without brackets
 * @param user the account in the database
 * @param tls settings of TLS, by the names of PostgreSQL
 */
public record PostgresUrl(
        String host, int port, String database, String user, Map<String, String> tls) {
    private static final List<String> SCHEMES = List.of("postgresql", "postgres");
    private static final String EXPECTED = "expected postgresql://USER@HOST:PORT/DATABASE";
    private static final int PORT = 5432;
    private static final String MODE = "sslmode";
    private static final Set<String> TLS = Set.of(MODE, "sslrootcert", "sslcert", "sslkey");
    private static final Set<String> MODES =
            Set.of("disable", "allow", "prefer", "require", "verify-ca", "verify-full");
    private static final Set<String> LOOPBACK = Set.of("localhost", "127.0.0.1", "::1");

    /** Copies the settings. */
    public PostgresUrl {
        tls = Map.copyOf(tls);
    }

    /**
     * Returns the address in a text; empty if the text has no scheme and is therefore a file.
     *
     * @throws IllegalArgumentException if the text has a scheme and is no address of a database;
     *     the message contains no password
     */
    public static Optional<PostgresUrl> find(String text) {
        int end = text.indexOf("://");
        if (end < 1 || !text.substring(0, end).matches("[A-Za-z][A-Za-z0-9+.-]*")) {
            return Optional.empty();
        }
        String scheme = text.substring(0, end);
        if (!SCHEMES.contains(scheme)) {
            throw new IllegalArgumentException(
                    "the store is a URL of the kind "
                            + scheme
                            + "://, "
                            + EXPECTED
                            + ", or a file");
        }
        return Optional.of(parse(text));
    }

    private static PostgresUrl parse(String text) {
        URI uri;
        try {
            uri = new URI(text);
        } catch (URISyntaxException e) {
            // The message of the exception is not used, because it would repeat a password.
            throw new IllegalArgumentException(
                    "the URL of the store is broken at character "
                            + (e.getIndex() + 1)
                            + ": "
                            + e.getReason()
                            + "; "
                            + EXPECTED,
                    null);
        }
        String account = Optional.ofNullable(uri.getRawUserInfo()).orElse("");
        if (account.contains(":")) {
            throw new IllegalArgumentException(
                    "the URL of the store contains a password, which other users of this machine"
                            + " could read in the list of processes; write it into ~/.pgpass, as"
                            + " HOST:PORT:DATABASE:USER:PASSWORD, and "
                            + EXPECTED);
        }
        String database = uri.getRawPath() == null ? "" : uri.getRawPath().replaceFirst("^/", "");
        if (uri.getHost() == null
                || database.isEmpty()
                || database.contains("/")
                || uri.getRawFragment() != null) {
            throw new IllegalArgumentException(
                    "the URL of the store names "
                            + (uri.getHost() == null ? "no host" : "no database")
                            + ", "
                            + EXPECTED);
        }
        return new PostgresUrl(
                uri.getHost().replaceAll("^\\[|]$", ""),
                uri.getPort() < 0 ? PORT : uri.getPort(),
                decoded(database),
                account.isEmpty() ? System.getProperty("user.name") : decoded(account),
                settings(Optional.ofNullable(uri.getRawQuery()).orElse("")));
    }

    private static Map<String, String> settings(String query) {
        Map<String, String> settings = new LinkedHashMap<>();
        for (String each : query.isEmpty() ? new String[0] : query.split("&")) {
            String name = each.replaceFirst("=.*", "");
            if (!TLS.contains(name)) {
                throw new IllegalArgumentException(
                        "the URL of the store has the setting "
                                + name
                                + ", expected one of "
                                + String.join(", ", TLS.stream().sorted().toList()));
            }
            settings.put(name, decoded(each.substring(Math.min(each.length(), name.length() + 1))));
        }
        String mode = settings.get(MODE);
        if (mode != null && !MODES.contains(mode)) {
            throw new IllegalArgumentException(
                    "the URL of the store has "
                            + MODE
                            + "="
                            + mode
                            + ", expected one of "
                            + String.join(", ", MODES.stream().sorted().toList()));
        }
        return settings;
    }

    private static String decoded(String part) {
        return URLDecoder.decode(part.replace("+", "%2B"), StandardCharsets.UTF_8);
    }

    private static String encoded(String part) {
        return URLEncoder.encode(part, StandardCharsets.UTF_8).replace("+", "%20");
    }

    /** Returns the address in the form of the driver, without the user and the settings. */
    String forDriver() {
        return "jdbc:postgresql://" + place() + "/" + encoded(database);
    }

    /**
     * Returns the user and the settings for the driver. A connection to another machine is
     * encrypted and verified, unless the address has another {@code sslmode}.
     */
    Properties properties() {
        Properties properties = new Properties();
        properties.setProperty("user", user);
        properties.setProperty(MODE, LOOPBACK.contains(host) ? "prefer" : "verify-full");
        tls.forEach(properties::setProperty);
        return properties;
    }

    private String place() {
        return (host.contains(":") ? "[" + host + "]" : host) + ":" + port;
    }

    /** Returns the address without its settings, for messages. */
    @Override
    public String toString() {
        return "postgresql://" + encoded(user) + "@" + place() + "/" + encoded(database);
    }
}
