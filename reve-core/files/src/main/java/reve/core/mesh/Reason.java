// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import org.jspecify.annotations.Nullable;

import java.nio.file.AccessDeniedException;
import java.nio.file.FileSystemException;
import java.util.regex.Pattern;

/** Puts what libraries and the system say about a file into words for its author. */
final class Reason {
    /** Names of Java classes and methods, which say nothing about a file. */
    private static final Pattern CODE =
            Pattern.compile(
                    "\\b[a-z]\\w*(\\.\\w+)*\\.[A-Z]\\w*|[A-Z]\\w+(Exception|Error)\\b|\\w+\\(\\)|\"<");

    private static final int MAX_LENGTH = 200;

    private Reason() {}

    /** The first line of a message; {@code otherwise} if there is none, or it is about code. */
    static String of(Exception broken, String otherwise) {
        return broken instanceof NullPointerException
                ? otherwise
                : of(broken.getMessage(), otherwise);
    }

    /** As the other one. */
    static String of(@Nullable String message, String otherwise) {
        String line = message == null ? "" : message.lines().findFirst().orElse("").strip();
        if (line.isEmpty() || CODE.matcher(line).find()) {
            return otherwise;
        }
        return line.length() <= MAX_LENGTH ? line : line.substring(0, MAX_LENGTH - 1) + "…";
    }

    /** Why the system does not read a file. */
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
