// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/**
 * The fenced code blocks of one of the project's Markdown files. With them, tests run the code that
 * people read.
 */
record Document(Path path, List<Block> blocks) {
    private static final Pattern FENCE =
            Pattern.compile(
                    "^```(\\w+)(?: title=(\\S+))?\\R(.*?)^```$",
                    Pattern.MULTILINE | Pattern.DOTALL);

    /** A block of code. Its title is the name of its file, or empty if the page gives none. */
    record Block(String language, String title, String text) {}

    static Document read(Path path) throws IOException {
        List<Block> blocks = new ArrayList<>();
        Matcher fence = FENCE.matcher(Files.readString(path));
        while (fence.find()) {
            String title = fence.group(2) == null ? "" : fence.group(2);
            blocks.add(new Block(fence.group(1), title, fence.group(3)));
        }
        return new Document(path, List.copyOf(blocks));
    }

    /** Returns the block that has this file name. */
    Block titled(String title) {
        return blocks.stream()
                .filter(block -> block.title().equals(title))
                .findFirst()
                .orElseThrow(
                        () -> new IllegalArgumentException(path + " has no block titled " + title));
    }
}
