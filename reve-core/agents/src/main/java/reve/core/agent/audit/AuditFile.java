// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.audit;

import org.jspecify.annotations.Nullable;

import reve.core.agent.auth.TokenFile;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.Json;
import reve.core.agent.protocol.MessagePackReader;
import reve.core.disk.OwnedFile;
import reve.core.disk.Reason;
import reve.core.text.Visible;

import tools.jackson.databind.node.ObjectNode;

import java.io.Closeable;
import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.channels.FileChannel;
import java.nio.charset.StandardCharsets;
import java.nio.file.AccessDeniedException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.security.MessageDigest;
import java.security.NoSuchAlgorithmException;
import java.time.Instant;
import java.time.InstantSource;
import java.util.Base64;
import java.util.HexFormat;
import java.util.List;
import java.util.Optional;
import java.util.function.LongSupplier;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/**
 * The file of an {@link AuditLog}: one JSON object per message, with the time of the message.
 * Secrets are omitted, and pixels of pictures are replaced by a hash (SHA-256). A file that reaches
 * the maximum size is rotated. This class only counts messages while the file cannot be written,
 * and tries to write once per second. The first record after such a gap contains the number of
 * missing records. For one thread, which blocks while the disk does not answer.
 */
final class AuditFile implements Closeable {

    private static final List<String> PIXELS = List.of("colour", "depth", "items");
    private static final Pattern SECRET =
            Pattern.compile("(?<=\"session\":\\{\"token\":\")[0-9a-f]+");
    private static final Pattern HEAD =
            Pattern.compile("\\{\"at\":\"[^\"]{1,40}\",\"(world|unrecorded)\":");
    private static final Pattern REPORT_OF_RECORDS =
            Pattern.compile("\\{\"t\":\"report\",\"id\":\\d+,\"frame\":\\d+,\"of\":\"audit\",");
    private static final int HEAD_BYTES = 80;
    private static final int READ_BYTES = 1 << 16;
    private static final long RETRY_NANOS = 1_000_000_000;

    private final AuditPlan plan;
    private final Path file;
    private final InstantSource clock;
    private final LongSupplier nanos;
    private final RecentRecords recent = new RecentRecords();
    private OwnedFile out;
    private long size;

    /** Size at which the file is rotated [bytes]. */
    private long fullSize;

    /** True if the file ends with an incomplete record, for example after a crash. */
    private boolean torn;

    /** Number of messages without a record since the last successful write. */
    private long missing;

    private Instant missingSince = Instant.EPOCH;
    private long triedNanos;
    private @Nullable String failure;
    private @Nullable String rotationFailure;
    private String lastGap = "";
    private long unrecorded;

    /**
     * @param clock the time of a gap's record
     * @param nanos a clock like {@link System#nanoTime}
     * @throws IOException if the file cannot be appended to, or is no audit record
     */
    AuditFile(AuditPlan plan, InstantSource clock, LongSupplier nanos) throws IOException {
        this.plan = plan;
        this.file = plan.file();
        this.clock = clock;
        this.nanos = nanos;
        try {
            OwnedFile.requireOlder(file, plan.keep(), AuditFile::requireRecord);
            out = open();
        } catch (IOException e) {
            throw new IOException(
                    "the audit record " + file + " could not be opened: " + Reason.of(e), e);
        }
    }

    /**
     * Opens and locks the file. First checks, without a lock, that the file is an audit record. An
     * incomplete last record is allowed, because a crash may have left it.
     */
    private OwnedFile open() throws IOException {
        boolean regular = !Files.exists(file) || Files.isRegularFile(file);
        boolean cut = regular && Files.exists(file) && !endsWithLine();
        OwnedFile opened = OwnedFile.open(file, TokenFile.PRIVATE);
        size = opened.channel().size();
        fullSize = regular ? plan.maxBytes() : Long.MAX_VALUE;
        torn = cut;
        return opened;
    }

    /**
     * Returns whether the file ends with a complete record. Throws an exception, without changing
     * the file, if the file is not an audit record.
     */
    private boolean endsWithLine() throws IOException {
        try (FileChannel in = FileChannel.open(file)) {
            long next = requireRecord(in, "it");
            return next == in.size();
        }
    }

    /**
     * Throws an exception if an older file is no audit record. Rotation would rename or replace
     * this file.
     */
    private static void requireRecord(Path older) throws IOException {
        try (FileChannel in = FileChannel.open(older)) {
            requireRecord(in, older.toString());
        } catch (AccessDeniedException e) {
            throw new IOException(older + " cannot be read: permission denied", e);
        }
    }

    /**
     * Returns the position at which the last line begins. The last line may be incomplete. Throws
     * an exception if the file is no audit record.
     */
    private static long requireRecord(FileChannel in, String name) throws IOException {
        // The first line is checked first. A file without a valid first line is refused at once,
        // whereas the search for the last line may read the whole file.
        long next = isRecord(in, 0) ? lineBefore(in, in.size()) : -1;
        if (next < 0 || next > 0 && !isRecord(in, lineBefore(in, next - 1))) {
            throw new IOException(
                    name
                            + " is there already and holds something else than an audit "
                            + "record; name another file, or move it away");
        }
        return next;
    }

    /**
     * Returns the position at which a line begins. It is the line that contains the byte before
     * {@code place}.
     */
    private static long lineBefore(FileChannel in, long place) throws IOException {
        ByteBuffer buffer = ByteBuffer.allocate(READ_BYTES);
        for (long end = place; end > 0; end -= buffer.capacity()) {
            long from = Math.max(0, end - buffer.capacity());
            int count = in.read(buffer.clear().limit((int) (end - from)), from);
            for (int i = count - 1; i >= 0; i--) {
                if (buffer.get(i) == '\n') {
                    return from + i + 1;
                }
            }
        }
        return 0;
    }

    /**
     * Returns whether the line at a position begins like a record. An incomplete record is
     * accepted.
     */
    private static boolean isRecord(FileChannel in, long start) throws IOException {
        ByteBuffer buffer = ByteBuffer.allocate(HEAD_BYTES);
        in.read(buffer, start);
        String line =
                new String(buffer.array(), 0, buffer.position(), StandardCharsets.UTF_8)
                        .lines()
                        .findFirst()
                        .orElse("");
        Matcher head = HEAD.matcher(line);
        return buffer.position() == 0 || !line.isEmpty() && (head.lookingAt() || head.hitEnd());
    }

    /**
     * Records a message.
     *
     * @param at time at which the message is written to the connection
     * @return false if recording failed and the message must therefore not be sent
     */
    boolean told(Instant at, String world, String client, Encoding encoding, ByteBuffer line) {
        if (!isWritable()) {
            return leaveOut();
        }
        String json =
                encoding == Encoding.JSON
                        ? withoutPixels(
                                StandardCharsets.UTF_8
                                        .decode(line.slice(0, line.remaining() - 1))
                                        .toString())
                        : MessagePackReader.read(
                                        line.slice(
                                                Encoding.LENGTH_BYTES,
                                                line.remaining() - Encoding.LENGTH_BYTES),
                                        AuditFile::hash)
                                .toString();
        String message = withoutRecords(withoutSecret(json));
        if (!write(
                "{\"at\":\""
                        + at
                        + "\",\"world\":\""
                        + world
                        + "\",\"client\":\""
                        + client
                        + "\",\"message\":"
                        + message
                        + "}")) {
            return leaveOut();
        }
        recent.add(at, world, client, message);
        return true;
    }

    /** Returns the newest records. For any thread. */
    RecentRecords recent() {
        return recent;
    }

    private boolean leaveOut() {
        if (plan.required()) {
            return false;
        }
        missing++;
        unrecorded++;
        return true;
    }

    /**
     * Returns whether messages may be sent. They may be sent if the record can be written or is not
     * required.
     */
    boolean isServing() {
        return !plan.required() || isWritable();
    }

    /**
     * Returns why the record cannot be written or rotated, or what another program did to the file;
     * empty if there is no problem. A new record begins at the path of a file that was moved,
     * removed or truncated.
     */
    Optional<String> problem() {
        String trouble = failure == null ? out.trouble(size) : "";
        if (!trouble.isEmpty()) {
            beginAnew();
            if (failure == null) {
                return Optional.of(
                        "the audit record "
                                + file
                                + " "
                                + trouble
                                + "; a new one"
                                + " begins there, which lacks what was recorded before");
            }
        }
        return isWritable()
                ? Optional.ofNullable(rotationFailure)
                : Optional.of(
                        "what clients are sent cannot be recorded in "
                                + file
                                + ": "
                                + failure
                                + plan.consequence());
    }

    /** Returns the message for the operator that a problem has ended. */
    String solved() {
        return "what clients are sent is recorded in " + file + " again" + lastGap;
    }

    /** Returns the number of messages sent so far without a record. */
    long unrecorded() {
        return unrecorded;
    }

    /**
     * Records that messages have no record because the disk did not answer in time.
     *
     * @param since when the first of these messages was sent
     */
    void skipped(long messages, Instant since) {
        unrecorded += messages;
        if (missing == 0) {
            missingSince = since;
        }
        missing += messages;
        if (failure == null) {
            recordGap();
        }
    }

    private void beginAnew() {
        lastGap = "";
        closeQuietly(out);
        try {
            out = open();
            rotationFailure = null;
        } catch (IOException e) {
            failed(e);
        }
    }

    /**
     * Returns whether the file can be written. Tries once per second to open the path again after a
     * failure. The path may lead to another file by then.
     */
    private boolean isWritable() {
        if (failure == null) {
            return true;
        }
        if (nanos.getAsLong() - triedNanos < RETRY_NANOS) {
            return false;
        }
        triedNanos = nanos.getAsLong();
        closeQuietly(out); // closing the file releases its lock
        try {
            out = open();
        } catch (IOException e) {
            failure = Reason.of(e);
            return false;
        }
        failure = null;
        return recordGap();
    }

    /** Records how many messages have no record. Returns whether this succeeded. */
    private boolean recordGap() {
        if (write(
                "{\"at\":\""
                        + clock.instant()
                        + "\",\"unrecorded\":"
                        + missing
                        + ",\"since\":\""
                        + missingSince
                        + "\"}")) {
            lastGap =
                    plan.required()
                            ? ""
                            : "; "
                                    + missing
                                    + " messages since "
                                    + missingSince
                                    + " have no record";
            missing = 0;
            return true;
        }
        return false;
    }

    private boolean write(String record) {
        ByteBuffer bytes =
                ByteBuffer.wrap(
                        ((torn ? "\n" : "") + Visible.json(record) + "\n")
                                .getBytes(StandardCharsets.UTF_8));
        if (size > 0 && size + bytes.remaining() > fullSize) {
            rotate();
        }
        try {
            while (bytes.hasRemaining()) {
                size += out.channel().write(bytes);
            }
            torn = false;
            return true;
        } catch (IOException e) {
            failed(e);
            takeBack(size - bytes.position());
            return false;
        }
    }

    private void failed(IOException e) {
        if (missing == 0) {
            missingSince = clock.instant();
        }
        failure = Reason.of(e);
        triedNanos = nanos.getAsLong();
    }

    private void takeBack(long end) {
        try {
            out.channel().truncate(end);
            size = end;
        } catch (IOException e) {
            torn = true;
        }
    }

    /**
     * Renames each older file to the next number, and removes the oldest. The renaming fails, for
     * example, if an older file is in use or is no audit record. The current file then stays in use
     * and grows beyond its maximum size.
     */
    private void rotate() {
        if (!out.isInPlace()) { // the file was moved or removed: problem() begins a new one
            return;
        }
        try {
            OwnedFile.rotate(file, plan.keep(), AuditFile::requireRecord);
        } catch (IOException e) {
            rotationFailed(e);
            return;
        }
        OwnedFile full = out;
        try {
            out = open();
            rotationFailure = null;
        } catch (IOException e) {
            // The full file stays in use, even if it was already renamed.
            out = full;
            rotationFailed(e);
            return;
        }
        closeQuietly(full);
    }

    private static void closeQuietly(OwnedFile closing) {
        try {
            closing.close();
        } catch (IOException e) {
            // This class buffers no data, so a failed close loses nothing.
        }
    }

    private void rotationFailed(IOException e) {
        fullSize = size + plan.maxBytes();
        rotationFailure =
                "the audit record "
                        + file
                        + " cannot be rotated: "
                        + Reason.of(e)
                        + "; it grows beyond "
                        + plan.maxBytes()
                        + " bytes";
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

    /**
     * Replaces the records in a report of records by their hash. Otherwise each report would
     * contain the report before it, and the reports would grow without end.
     */
    private static String withoutRecords(String json) {
        if (!REPORT_OF_RECORDS.matcher(json).lookingAt()) {
            return json;
        }
        var report = (ObjectNode) Json.MAPPER.readTree(json);
        var content = (ObjectNode) report.get("content");
        content.put(
                "records",
                hash(content.get("records").toString().getBytes(StandardCharsets.UTF_8)));
        return report.toString();
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
                ? SECRET.matcher(json).replaceFirst("…")
                : json;
    }

    @Override
    public void close() throws IOException {
        out.close();
    }
}
