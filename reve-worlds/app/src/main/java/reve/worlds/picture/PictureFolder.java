// SPDX-License-Identifier: Apache-2.0
package reve.worlds.picture;

import java.awt.image.BufferedImage;
import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Locale;

/** A video as a folder of PNG files: {@code 000000.png} and so on. */
public final class PictureFolder implements FrameSink {
    private final Path folder;
    private int count;

    /**
     * @param folder an existing folder
     */
    public PictureFolder(Path folder) {
        this.folder = folder;
    }

    /** Returns the name of a picture. */
    public static String name(int number) {
        return String.format(Locale.ROOT, "%06d.png", number);
    }

    @Override
    public void add(BufferedImage picture) throws IOException {
        LayerFiles.writePng(picture, folder.resolve(name(count)));
        count++;
    }

    /**
     * Removes the remaining pictures of an earlier, longer video, so that the folder contains one
     * video only.
     */
    @Override
    public void finish() throws IOException {
        for (int next = count; Files.deleteIfExists(folder.resolve(name(next))); next++) {
            // The loop has no body, because its condition deletes the files.
        }
    }

    @Override
    public void close() {
        // This method removes nothing, because each picture so far is a complete file.
    }
}
