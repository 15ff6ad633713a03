// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.mesh.AssetException;
import reve.core.mesh.WorldFolder;

import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.text.Normalizer;
import java.util.HashMap;
import java.util.Locale;
import java.util.Map;

/**
 * Check of the names and the total size of the files in one {@link WorldPack} against the limits of
 * packs. The same checks apply when a pack is made and when it is opened. For one thread.
 */
final class PackNames {
    /** Longest name of one file or folder that file systems store [bytes of UTF-8]. */
    private static final int MAX_PART_BYTES = 255;

    private final Path pack;

    /**
     * The names of files and folders, by a normalised form. Names with the same form may be the
     * same file in some file systems.
     */
    private final Map<String, String> taken = new HashMap<>();

    private final Map<String, String> files = new HashMap<>();
    private long bytes;

    PackNames(Path pack) {
        this.pack = pack;
    }

    /** Checks the name of a file, or of a folder if the name ends with a slash. */
    void add(String entry) throws PackException {
        boolean isFolder = entry.endsWith("/");
        String name = isFolder ? entry.substring(0, entry.length() - 1) : entry;
        try {
            WorldFolder.requireWithin(name);
        } catch (AssetException refused) {
            throw new PackException(pack + ": " + refused.getMessage(), refused);
        }
        requireShort(name);
        for (int end = name.indexOf('/'); end >= 0; end = name.indexOf('/', end + 1)) {
            addFolder(name.substring(0, end));
        }
        if (isFolder) {
            addFolder(name);
            return;
        }
        String other = taken.putIfAbsent(joined(name), name);
        if (other != null) {
            throw collision(other, name);
        }
        files.put(joined(name), name);
        if (files.size() > WorldPack.MAX_FILES) {
            throw WorldPack.tooMany(pack, files.size());
        }
    }

    /** Checks that file systems can store the name. */
    private void requireShort(String name) throws PackException {
        for (String part : name.split("/")) {
            int length = part.getBytes(StandardCharsets.UTF_8).length;
            if (length > MAX_PART_BYTES) {
                throw new PackException(
                        pack
                                + ": the name `"
                                + Node.shorten(part)
                                + "` has "
                                + length
                                + " bytes; expected at most "
                                + MAX_PART_BYTES
                                + " in the name of a file or folder, rename it");
            }
        }
    }

    private void addFolder(String name) throws PackException {
        String other = taken.putIfAbsent(joined(name), name);
        if (other != null && (!other.equals(name) || files.containsKey(joined(name)))) {
            throw collision(other, name);
        }
    }

    /** Counts bytes of a file's content. Throws an exception if all files exceed the limit. */
    void take(String name, long count) throws PackException {
        bytes += count;
        if (bytes > WorldPack.MAX_BYTES) {
            throw new PackException(
                    pack
                            + ": its files have more than "
                            + (WorldPack.MAX_BYTES >> 20)
                            + " MiB together, of which at most this many are packed and opened ("
                            + name
                            + " exceeds them)");
        }
    }

    private PackException collision(String one, String other) {
        return new PackException(
                pack
                        + ": `"
                        + Node.shorten(one)
                        + "` and `"
                        + Node.shorten(other)
                        + "` are one name on some machines; expected names that differ in more"
                        + " than case, rename one of them");
    }

    private static String joined(String name) {
        return Normalizer.normalize(name, Normalizer.Form.NFKC).toLowerCase(Locale.ROOT);
    }
}
