package reve.core.agent;

import java.io.Closeable;
import java.io.IOException;
import java.io.OutputStream;
import java.io.UncheckedIOException;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.AccessDeniedException;
import java.nio.file.FileSystemException;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.security.MessageDigest;
import java.security.NoSuchAlgorithmException;
import java.time.Clock;
import java.util.Base64;
import java.util.HexFormat;
import java.util.List;
import java.util.regex.Pattern;
import tools.jackson.databind.node.ObjectNode;

/**
 * A record of exactly what each client was told, and when: one JSON object per message, appended to
 * a file at the moment in which the message is written to the connection; of secrets, only that
 * they were told, and of the pixels of pictures a hash (SHA-256). What cannot be recorded is not
 * told. Any thread.
 */
final class AuditLog implements Closeable {

    private static final List<String> PIXELS = List.of("colour", "depth", "items");
    private static final Pattern SECRET =
            Pattern.compile("(?<=\"session\":\\{\"token\":\")[0-9a-f]+");

    private final Path file;
    private final OutputStream out;
    private final Clock clock;

    /** @throws IOException if the file cannot be appended to */
    AuditLog(Path file, Clock clock) throws IOException {
        this.file = file;
        this.clock = clock;
        try {
            out = Files.newOutputStream(file, StandardOpenOption.CREATE, StandardOpenOption.APPEND);
        } catch (FileSystemException e) {
            String reason = switch (e) {
                case NoSuchFileException gone ->
                        "there is no folder " + file.toAbsolutePath().getParent();
                case AccessDeniedException denied -> "permission denied";
                default -> e.getReason();
            };
            throw new IOException(
                    "the audit record " + file + " could not be opened: " + reason, e);
        }
    }

    /** @throws UncheckedIOException if it cannot be written down */
    synchronized void told(String world, String client, Encoding encoding, ByteBuffer line) {
        String json = encoding == Encoding.JSON
                ? withoutPixels(StandardCharsets.UTF_8
                        .decode(line.slice(0, line.remaining() - 1)).toString())
                : MessagePackReader.read(
                        line.slice(Encoding.LENGTH_BYTES, line.remaining() - Encoding.LENGTH_BYTES),
                        AuditLog::hash).toString();
        String entry = "{\"at\":\"" + clock.instant() + "\",\"world\":\"" + world
                + "\",\"client\":\"" + client + "\",\"message\":" + withoutSecret(json) + "}\n";
        try {
            out.write(entry.getBytes(StandardCharsets.UTF_8));
        } catch (IOException e) {
            throw new UncheckedIOException("what clients are told cannot be recorded in " + file
                    + ": " + e.getMessage(), e);
        }
    }

    private static String withoutPixels(String json) {
        if (!json.startsWith("{\"t\":\"image\"")) {
            return json;
        }
        var image = (ObjectNode) Json.MAPPER.readTree(json);
        for (String layer : PIXELS) {
            if (image.has(layer)) {
                image.put(layer, hash(Base64.getDecoder().decode(image.get(layer).stringValue())));
            }
        }
        return image.toString();
    }

    private static String hash(byte[] bytes) {
        try {
            byte[] digest = MessageDigest.getInstance("SHA-256").digest(bytes);
            return "sha256:" + HexFormat.of().formatHex(digest);
        } catch (NoSuchAlgorithmException impossible) {
            throw new AssertionError("every JDK has SHA-256", impossible);
        }
    }

    private static String withoutSecret(String json) {
        return json.startsWith("{\"t\":\"welcome\"")
                ? SECRET.matcher(json).replaceFirst("…") : json;
    }

    @Override
    public void close() throws IOException {
        out.close();
    }
}
