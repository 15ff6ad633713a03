// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.image.CorruptException;
import reve.worlds.Product;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.LinkOption;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.SortedMap;
import java.util.TreeMap;
import java.util.UUID;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/**
 * The content of a store's files, and the damage that reading them has found. Reading a store
 * changes no file. For one thread. No other process may have the store open.
 */
public final class StoreContents implements StoreReading {
    private static final String NOT_VOUCHED = ", so the newest frames may be missing, too";

    /** Names of the files that belong to a store. */
    private static final Pattern OWN_NAME =
            Pattern.compile("-(wal|shm|journal|manifest|frames-\\d+)$");

    /** Messages about damage that loses no data. Each message names the file. */
    private final List<String> harmless = new ArrayList<>();

    /** Messages about damage that loses data. Each message names the file. */
    private final List<String> damage = new ArrayList<>();

    private final Path file;
    private final StoreDatabase.Rows rows;
    private final Optional<Manifest.Claim> claim;
    private final UUID id;
    private final TreeMap<Long, Path> files;
    private final SortedMap<Long, FrameFile> read = new TreeMap<>();
    private @Nullable Start start;
    private long known;

    /** The part of a file of frames that can be read. */
    private record FrameFile(
            long number,
            Path file,
            Optional<RunLog.Link> link,
            List<JournalRecord> records,
            Optional<String> damage) {}

    /**
     * An image and the frames that follow it without a gap.
     *
     * @param why the reason why the frames end there, or why the image was not read from the
     *     expected place
     * @param isTail whether a power failure may explain all damage, because only the newest data is
     *     missing
     */
    private record Start(
            StoreDatabase.ImageRow row,
            JournalRecord.Image image,
            List<JournalRecord> after,
            long frame,
            List<String> why,
            boolean isTail) {}

    /**
     * Reads a store; a missing file counts as an empty store.
     *
     * @throws CorruptException if the file is not a store, or the store has another version or no
     *     database
     * @throws IOException if a file cannot be read, or another process has the store open
     */
    public static StoreContents read(Path file) throws IOException {
        requirePlace(file);
        TreeMap<Long, Path> files = FrameFiles.present(file);
        requireFiles(file, files);
        if (!Files.exists(file) || Files.size(file) == 0) {
            requireNothingBeside(file, files);
            return new StoreContents(file, StoreDatabase.Rows.NONE, files);
        }
        return new StoreContents(file, StoreDatabase.read(file), files);
    }

    private StoreContents(Path file, StoreDatabase.Rows rows, TreeMap<Long, Path> files)
            throws IOException {
        this.file = file;
        this.rows = rows;
        this.files = files;
        damage.addAll(rows.damage());
        claim = readClaim();
        id =
                claim.filter(claimed -> rows.identity().isEmpty() || isOf(claimed))
                        .map(Manifest.Claim::store)
                        .or(() -> rows.identity().map(StoreDatabase.Identity::id))
                        .orElseGet(UUID::randomUUID);
        requireImageBeforeFrames();
        if (isEmpty()) {
            return;
        }
        compareWithManifest();
        checkLinks();
        compareFramesWithManifest();
        if (isStranger()) {
            damage.add(file + " belongs to another store than all the files beside it");
        } else {
            findStart();
        }
        judge();
    }

    /** Returns the file of the database. */
    public Path file() {
        return file;
    }

    @Override
    public String name() {
        return file.toString();
    }

    @Override
    public boolean isEmpty() {
        return rows.images().isEmpty()
                && rows.damage().isEmpty()
                && claim.map(Manifest.Claim::image).orElse(0L) == 0
                && damage.isEmpty();
    }

    @Override
    public boolean isWhole() {
        return damage.isEmpty();
    }

    @Override
    public List<String> problems() {
        return Stream.concat(damage.stream(), harmless.stream()).distinct().toList();
    }

    @Override
    public long frame() {
        return start == null ? -1 : start.frame();
    }

    @Override
    public long knownFrame() {
        return known;
    }

    @Override
    public List<JournalRecord> records() {
        List<JournalRecord> records = new ArrayList<>();
        rows.libraries()
                .forEach((sha256, bytes) -> records.add(new JournalRecord.Library(sha256, bytes)));
        if (start != null) {
            records.add(start.image());
            records.addAll(start.after());
        }
        return records;
    }

    /** Returns all existing paths of the store, also those at which there is no regular file. */
    public List<Path> files() {
        List<Path> all = new ArrayList<>(List.of(file));
        all.addAll(files.values());
        all.add(Manifest.path(file));
        all.addAll(StoreDatabase.besides(file));
        return all.stream().filter(each -> Files.exists(each, LinkOption.NOFOLLOW_LINKS)).toList();
    }

    @Override
    public void requireWhole() {
        if (!isWhole()) {
            throw refusal(String.join("; ", damage), frame());
        }
    }

    @Override
    public CorruptException refusal(String reason, long frame) {
        String left =
                frame < 0
                        ? "Nothing can be recovered from these files: put them back from "
                                + "a copy, or name another file"
                        : "It can continue from frame "
                                + frame
                                + (known > frame
                                        ? "; frames "
                                                + (frame + 1)
                                                + " to "
                                                + known
                                                + " would be lost"
                                        : "")
                                + ". Put back what is missing from a copy, or recover what is left:"
                                + " "
                                + Product.command()
                                + " store repair "
                                + file;
        return new CorruptException(
                file + " is not whole: " + reason + ". " + left + " (nothing was changed)");
    }

    /** Returns the content of the manifest for a store that resumes from this content. */
    Manifest.Claim claim() {
        Manifest.Claim begin = Manifest.Claim.nothing(id);
        return start == null
                ? begin
                : new Manifest.Claim(
                        id,
                        begin.boot(),
                        lastFile(),
                        lastId(),
                        start.frame(),
                        start.row().framesFile(),
                        start.row().frame(),
                        start.row().sum());
    }

    /** Returns the number of the newest file of frames that exists or existed; 0 for none. */
    long lastFile() {
        // Files that cannot be read count, too.
        long newest = files.isEmpty() ? 0 : files.lastKey();
        for (StoreDatabase.ImageRow row : rows.images()) {
            newest = Math.max(newest, row.framesFile());
        }
        return Math.max(newest, claim.map(Manifest.Claim::file).orElse(0L));
    }

    long lastId() {
        return Optional.ofNullable(read.get(lastFile()))
                .flatMap(FrameFile::link)
                .map(RunLog.Link::id)
                .orElse(0L);
    }

    UUID id() {
        return id;
    }

    boolean hasIdentity() {
        return rows.identity().isPresent();
    }

    @Override
    public List<String> damagedLibraries() {
        return rows.damagedLibraries();
    }

    private Optional<Manifest.Claim> readClaim() throws IOException {
        try {
            Optional<Manifest.Claim> found = Manifest.read(file);
            if (found.isEmpty() && rows.identity().isPresent()) {
                damage.add(
                        Manifest.path(file)
                                + " is "
                                + (Files.exists(Manifest.path(file)) ? "empty" : "missing")
                                + NOT_VOUCHED);
            }
            return found;
        } catch (CorruptException e) {
            damage.add(e.getMessage());
            return Optional.empty();
        }
    }

    /** Returns whether a manifest describes exactly the newest image in the database. */
    private boolean isOf(Manifest.Claim claimed) {
        return rows.images().stream()
                .anyMatch(
                        row ->
                                row.isGood()
                                        && row.framesFile() == claimed.image()
                                        && row.sum() == claimed.imageSum());
    }

    private void requireImageBeforeFrames() throws IOException {
        if (rows.images().isEmpty()) {
            for (Path each : files.values()) {
                if (Files.isRegularFile(each) && Files.size(each) > RunLog.LINKED_BYTES) {
                    damage.add(file + " holds no image, but " + each + " holds frames");
                }
            }
        } else if (rows.isIdentified() && rows.identity().isEmpty()) {
            damage.add(file + " has lost its identity");
        }
    }

    private void compareWithManifest() {
        if (claim.isEmpty()) {
            return;
        }
        Manifest.Claim claimed = claim.get();
        known = claimed.frame();
        Path manifest = Manifest.path(file);
        if (rows.identity().isPresent() && !rows.identity().get().id().equals(claimed.store())) {
            damage.add(
                    isOf(claimed)
                            ? file + " has another identity than " + manifest
                            : manifest + " belongs to another store than " + file);
            known = id.equals(claimed.store()) ? known : 0;
        } else if (claimed.image() > 0 && rows.identity().isEmpty()) {
            damage.add(file + " is an older copy, from before " + manifest);
        }
        boolean has = false;
        for (StoreDatabase.ImageRow row : rows.images()) {
            has |= row.framesFile() >= claimed.image();
            if (row.isGood()
                    && row.framesFile() == claimed.image()
                    && row.sum() != claimed.imageSum()) {
                damage.add(file + " belongs to another copy of the store than " + manifest);
            }
        }
        if (rows.images().stream().anyMatch(row -> row.framesFile() > claimed.file())) {
            damage.add(older(file));
        }
        if (claimed.image() > 0 && !has) {
            harmless.add(
                    file
                            + " lacks the image of frame "
                            + claimed.imageFrame()
                            + ": it is an "
                            + "older copy, or "
                            + file
                            + "-wal was lost");
        }
    }

    /**
     * Checks that each file of frames belongs to this store and continues the previous file.
     * Ignores files of other stores.
     */
    private void checkLinks() throws IOException {
        long first =
                rows.images().stream()
                        .mapToLong(StoreDatabase.ImageRow::framesFile)
                        .min()
                        .orElse(1);
        RunLog.@Nullable Link before = null;
        for (long number : files.tailMap(first).keySet()) {
            FrameFile each = frames(number);
            Optional<String> foreign = foreign(each, before);
            foreign.ifPresent(damage::add);
            if (foreign.isEmpty()) {
                read.put(number, each);
                before = each.link().orElse(null);
            }
        }
    }

    /**
     * Compares the files of frames with the manifest. The manifest names a file of frames before
     * the file contains a frame. Therefore a file with frames that the manifest does not name
     * counts as damage. The only exception is a power failure that has lost the newest content of
     * the manifest. This loss cannot include a committed image, because the manifest is flushed
     * before an image is committed.
     */
    private void compareFramesWithManifest() {
        claim.ifPresent(
                claimed ->
                        read.tailMap(claimed.file() + 1).values().stream()
                                .filter(
                                        each ->
                                                !each.records().isEmpty()
                                                        || each.damage().isPresent())
                                .forEach(
                                        each ->
                                                (claimed.isOfAnotherBoot() ? harmless : damage)
                                                        .add(older(each.file()))));
    }

    private String older(Path than) {
        return Manifest.path(file) + " is older than " + than + NOT_VOUCHED;
    }

    /** Returns whether the database and the files beside it belong to different stores. */
    private boolean isStranger() {
        return claim.isPresent()
                && !id.equals(claim.get().store())
                && read.values().stream().allMatch(each -> each.link().isEmpty());
    }

    private Optional<String> foreign(FrameFile each, RunLog.@Nullable Link before) {
        if (each.link().isEmpty()) {
            boolean isNoFrames = claim.isPresent() && each.number() > claim.get().file() + 1;
            return each.number() >= since() && (isNoFrames || !each.records().isEmpty())
                    ? Optional.of(each.file() + " does not say which store it belongs to")
                    : Optional.empty();
        }
        RunLog.Link link = each.link().get();
        if (!link.store().equals(id)) {
            return Optional.of(each.file() + " belongs to another store than " + file);
        }
        if (link.number() != each.number()) {
            return Optional.of(
                    each.file() + " was " + FrameFiles.path(file, link.number()).getFileName());
        }
        boolean isClaimed =
                claim.isEmpty()
                        || link.number() != claim.get().file()
                        || link.id() == claim.get().fileId();
        boolean continues =
                before == null
                        || before.number() != link.number() - 1
                        || link.before() == before.id();
        return isClaimed && continues
                ? Optional.empty()
                : Optional.of(each.file() + " belongs to another copy of the store");
    }

    /**
     * Returns the smallest number of a file of frames that must exist and contain the store's
     * identity.
     */
    private long since() {
        return rows.identity().map(StoreDatabase.Identity::since).orElse(Long.MAX_VALUE);
    }

    private FrameFile frames(long number) throws IOException {
        Path path = files.get(number);
        List<JournalRecord> records = new ArrayList<>();
        Optional<String> reason = FileTrouble.noFile(path);
        if (reason.isPresent() || Files.size(path) < RunLog.EMPTY_BYTES) {
            return new FrameFile(number, path, Optional.empty(), records, reason);
        }
        try (RunLog.Reader reader = RunLog.open(path)) {
            Optional<String> found = Optional.empty();
            try {
                reader.forEachRemaining(records::add);
            } catch (CorruptException e) {
                found = Optional.of(e.getMessage());
            }
            return new FrameFile(number, path, reader.link(), records, found);
        } catch (CorruptException e) {
            return new FrameFile(
                    number, path, Optional.empty(), records, Optional.of(e.getMessage()));
        } catch (IOException e) {
            throw FileTrouble.of(path, "read", e);
        }
    }

    /**
     * Chooses the image to start from. This is the newest readable image, or an older image if the
     * frames after it reach a later frame.
     */
    private void findStart() throws IOException {
        for (StoreDatabase.ImageRow row : rows.images()) {
            if (!row.isGood()) {
                harmless.add(file + ": the image of frame " + row.frame() + " is damaged");
                continue;
            }
            known = Math.max(known, row.frame());
            if (start == null || start.frame() < known) {
                Start found = from(row);
                if (start == null || found.frame() > start.frame()) {
                    start = found;
                }
            }
        }
    }

    private Start from(StoreDatabase.ImageRow row) throws IOException {
        List<JournalRecord> after = new ArrayList<>();
        List<String> why = new ArrayList<>();
        long frame = row.frame();
        long next = row.framesFile();
        boolean gap = false;
        boolean isTail = true;
        for (FrameFile each : read.tailMap(next).values()) {
            isTail &= !addMissing(next, each.number(), "", why);
            next = each.number() + 1;
            for (JournalRecord record : each.records()) {
                if (record instanceof JournalRecord.Frame made) {
                    known = Math.max(known, made.frame());
                    if (!gap && made.frame() != frame + 1) {
                        gap = true;
                        why.add(
                                each.file()
                                        + ": frame "
                                        + made.frame()
                                        + " follows frame "
                                        + frame
                                        + ", records are missing");
                    }
                    frame = gap ? frame : made.frame();
                }
                if (!gap) {
                    after.add(record);
                }
            }
            each.damage().ifPresent(why::add);
            isTail &= !gap && (each.damage().isEmpty() || isNewest(each));
        }
        boolean missing = addMissing(next, lastFile() + 1, "", why);
        isTail &= !missing || next == lastFile();
        return new Start(row, StoreDatabase.image(file, row), after, frame, why, isTail);
    }

    /**
     * Returns whether no later file contains a frame. A power failure just after a file was begun
     * may lose this file, its content, and the end of the previous file.
     */
    private boolean isNewest(FrameFile file) {
        FrameFile newest = read.get(lastFile());
        return file.number() == lastFile()
                || file.number() == lastFile() - 1
                        && (newest == null || newest.records().isEmpty());
    }

    /**
     * Adds the names of files that are missing from a range of numbers. Returns whether at least
     * one file is missing.
     */
    private boolean addMissing(long from, long before, String more, List<String> into) {
        long first = Math.max(from, since());
        if (first < before) {
            String last =
                    before - first == 1
                            ? ""
                            : " to " + FrameFiles.path(file, before - 1).getFileName();
            into.add(
                    FrameFiles.path(file, first)
                            + last
                            + (files.containsKey(first) ? " cannot be used" : " is missing")
                            + more);
        }
        return first < before;
    }

    /** Decides which damage loses data. Called after all parts of the store were read. */
    private void judge() {
        Start from = start;
        if (from == null) {
            if (rows.images().stream().noneMatch(StoreDatabase.ImageRow::isGood)) {
                damage.addFirst(file + " holds no image that can be read");
            }
            damage.addAll(harmless);
            return;
        }
        claim.filter(
                        claimed ->
                                from.row().framesFile() < claimed.image()
                                        && from.frame() <= claimed.imageFrame())
                .ifPresent(
                        claimed ->
                                damage.add(
                                        file
                                                + ": the last image, of frame "
                                                + claimed.imageFrame()
                                                + ", cannot be used; it may "
                                                + "hold edits that were made after that frame"));
        boolean damaged =
                read.tailMap(from.row().framesFile()).values().stream()
                        .anyMatch(each -> each.damage().isPresent());
        if (from.frame() >= known && !damaged) {
            (damage.isEmpty() ? harmless : damage).addAll(from.why());
            addOlderFiles(from.row().framesFile());
        } else if (damage.isEmpty()
                && from.isTail()
                && claim.isPresent()
                && claim.get().isOfAnotherBoot()) {
            harmless.addAll(from.why());
            harmless.add(
                    FrameFiles.path(file, lastFile())
                            + " ends at frame "
                            + from.frame()
                            + " of "
                            + known
                            + ": the machine was started again since, and the disk did "
                            + "not have the others");
        } else {
            damage.addAll(from.why());
            damage.addAll(harmless);
            if (damage.isEmpty()) {
                damage.add(
                        FrameFiles.path(file, lastFile())
                                + " ends at frame "
                                + from.frame()
                                + ", but went on to frame "
                                + known);
            }
        }
    }

    /**
     * Marks the damage of a file as harmless if only images older than the used one need the file.
     */
    private void addOlderFiles(long used) {
        long next = rows.images().getLast().framesFile();
        for (long number : read.headMap(used).keySet()) {
            addMissing(next, number, "; only older images needed it", harmless);
            next = number + 1;
        }
        addMissing(next, used, "; only older images needed it", harmless);
        read.headMap(used).values().forEach(each -> each.damage().ifPresent(harmless::add));
    }

    private static void requireNothingBeside(Path file, TreeMap<Long, Path> files)
            throws IOException {
        List<Path> beside = new ArrayList<>(files.values());
        Stream.concat(Stream.of(Manifest.path(file)), StoreDatabase.besides(file).stream())
                .filter(each -> Files.exists(each) && each.toFile().length() > 0)
                .forEach(beside::add);
        List<Path> aside = setAside(file);
        for (Path folder : aside) {
            if (Files.exists(folder.resolve(REPAIRED))) {
                throw new CorruptException(
                        file
                                + " is missing, because `store repair` was interrupted. All of its"
                                + " old files are in "
                                + folder
                                + " or still here. Move the files (not the folder "
                                + REPAIRED
                                + ") of "
                                + folder
                                + " back to this folder, and repair the store again (nothing was"
                                + " changed)");
            }
        }
        beside.addAll(aside);
        if (!beside.isEmpty()) {
            throw new CorruptException(
                    file
                            + (Files.exists(file) ? " is empty" : " is missing")
                            + ", but "
                            + beside.getFirst()
                            + (beside.size() > 1
                                    ? " and " + (beside.size() - 1) + " more beside it belong"
                                    : " beside it belongs")
                            + " to a store. Put "
                            + file.getFileName()
                            + " back from a copy; to begin a new world, name another file or move"
                            + " these away (nothing was changed)");
        }
    }

    /**
     * Name of the folder in STORE.damaged-N in which a repair writes the new files. It exists only
     * until the repair has ended.
     */
    public static final String REPAIRED = "repaired";

    /** Returns the folders to which repairs moved damaged files, STORE.damaged-1 and so on. */
    public static List<Path> setAside(Path file) throws IOException {
        String prefix = file.getFileName() + ".damaged-";
        try (Stream<Path> siblings = Files.list(file.toAbsolutePath().getParent())) {
            return siblings.filter(each -> each.getFileName().toString().startsWith(prefix))
                    .sorted()
                    .toList();
        }
    }

    /**
     * Refuses paths that are not regular files, because reading a pipe would block until another
     * process writes to it.
     */
    private static void requireFiles(Path file, TreeMap<Long, Path> files) throws IOException {
        List<Path> own = new ArrayList<>(files.values());
        own.add(file);
        own.add(Manifest.path(file));
        own.addAll(StoreDatabase.besides(file));
        own.add(StoreDatabase.rollback(file));
        for (Path each : own) {
            if (Files.exists(each) && !Files.isRegularFile(each) && !Files.isDirectory(each)) {
                throw new IOException(
                        each
                                + " is a device or a pipe, expected a file of the store "
                                + file
                                + "; move it away (nothing was changed)");
            }
        }
        // A dangling link is refused, because SQLite would create the file to which it points.
        for (Path each : StoreDatabase.besides(file)) {
            if (Files.isSymbolicLink(each) && !Files.exists(each)) {
                throw new IOException(
                        each
                                + " is a link to a file that is not there, expected a "
                                + "file of the store "
                                + file
                                + "; put that file back, or remove the link "
                                + "(nothing was changed)");
            }
        }
    }

    /** Refuses paths that cannot be the path of a store. */
    private static void requirePlace(Path file) throws IOException {
        Path parent = file.toAbsolutePath().getParent();
        if (Files.isDirectory(file) || parent == null) {
            throw new IOException(file + " is a folder, expected a file");
        }
        if (!Files.isDirectory(parent)) {
            throw new IOException(file + " could not be opened: there is no folder " + parent);
        }
        String name = file.getFileName().toString();
        if (file.toString().contains("?")) {
            // The database driver would read the text behind the question mark as options.
            throw new IOException(file + " contains a question mark; name the store without one");
        }
        if (OWN_NAME.matcher(name).find()) {
            throw new IOException(
                    file
                            + " has the name of a file that belongs to another store; name the"
                            + " store without the ending "
                            + name.substring(name.lastIndexOf('-')));
        }
    }
}
