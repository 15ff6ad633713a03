// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import org.jspecify.annotations.Nullable;

import java.nio.file.AccessDeniedException;
import java.nio.file.FileSystemException;
import java.util.regex.Pattern;

/**
 * Converter of exceptions from libraries and the system into reasons that the author of a file
 * understands.
 */
final class Reason {
    /** Pattern of names of Java classes and methods. They do not help the author of a file. */
    private static final Pattern CODE =
            Pattern.compile(
                    "\\b[a-z]\\w*(\\.\\w+)*\\.[A-Z]\\w*|[A-Z]\\w+(Exception|Error)\\b|\\w+\\(\\)|\"<");

    private static final int MAX_LENGTH = 200;

    private Reason() {}

    /**
     * Returns the first line of an exception's message. Returns {@code otherwise} if there is no
     * message or it contains names of code.
     */
    static String of(Exception broken, String otherwise) {
        return broken instanceof NullPointerException
                ? otherwise
                : of(broken.getMessage(), otherwise);
    }

    /**
     * Returns the first line of a message, under the same conditions as {@link #of(Exception,
     * String)}.
     */
    static String of(@Nullable String message, String otherwise) {
        String line = message == null ? "" : message.lines().findFirst().orElse("").strip();
        if (line.isEmpty() || CODE.matcher(line).find()) {
            return otherwise;
        }
        return line.length() <= MAX_LENGTH ? line : line.substring(0, MAX_LENGTH - 1) + "…";
    }

    /** Returns the reason why the operating system cannot read a file. */
    static String ofSystem(Exception unreadable) {
        if (unreadable instanceof AccessDeniedException) {
            return "permission denied";
        }
        if (unreadable instanceof FileSystemException file && file.getReason() != null) {
            return file.getReason();
        }
        return of(unreadable, "the system does not read it");
    }
}
