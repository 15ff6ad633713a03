// SPDX-License-Identifier: Apache-2.0
package reve.core.disk;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayDeque;
import java.util.Deque;

/**
 * A folder that a command fills with new files. If a file cannot be written, all that was made is
 * removed, and the command can be given again. For one thread.
 */
public final class NewFolder implements AutoCloseable {
    private final Path folder;

    /** The files and folders that were made, the newest first. */
    private final Deque<Path> made = new ArrayDeque<>();

    private boolean complete;

    /** Makes the folder if it does not exist. Its other files stay unchanged. */
    public NewFolder(Path folder) throws IOException {
        this.folder = folder;
        makeFolder(folder);
    }

    /**
     * Writes a new file, and makes the folders in which it is.
     *
     * @param name path of the file in this folder
     * @throws IOException naming the file and the reason
     */
    public void write(String name, byte[] content) throws IOException {
        Path file = folder.resolve(name);
        makeFolder(file.getParent());
        WholeFile.write(file, out -> out.write(content));
        made.push(file);
    }

    /** Keeps the files. */
    public void finish() {
        complete = true;
    }

    /** Removes all that was made unless the folder is complete. */
    @Override
    public void close() throws IOException {
        while (!complete && !made.isEmpty()) {
            Files.deleteIfExists(made.pop());
        }
    }

    private void makeFolder(Path wanted) throws IOException {
        if (!Files.isDirectory(wanted)) {
            if (wanted.getParent() != null) {
                makeFolder(wanted.getParent());
            }
            try {
                Files.createDirectory(wanted);
            } catch (IOException e) {
                throw Reason.naming(wanted, e);
            }
            made.push(wanted);
        }
    }
}
