// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.attribute.FileTime;
import java.nio.file.attribute.PosixFileAttributes;
import java.nio.file.attribute.PosixFilePermission;
import java.nio.file.attribute.PosixFilePermissions;
import java.util.EnumSet;
import java.util.Set;

/** The attributes of a file that identify its version, and its permissions. */
record FileVersion(
        FileTime modified,
        Object changed,
        long bytes,
        Object inode,
        boolean isFolder,
        boolean isFile,
        Set<PosixFilePermission> permissions) {

    /** Permissions for the owner only: mode 600. */
    static final Set<PosixFilePermission> OWNERS =
            EnumSet.of(PosixFilePermission.OWNER_READ, PosixFilePermission.OWNER_WRITE);

    /**
     * Reads the attributes of a file.
     *
     * @throws IOException if the file does not exist
     */
    static FileVersion of(Path path) throws IOException {
        PosixFileAttributes file = Files.readAttributes(path, PosixFileAttributes.class);
        return new FileVersion(
                file.lastModifiedTime(),
                Files.getAttribute(path, "unix:ctime"),
                file.size(),
                file.fileKey(),
                file.isDirectory(),
                file.isRegularFile(),
                file.permissions());
    }

    /** Returns whether users other than the owner may read or write the file. */
    boolean isOpenToOthers() {
        return permissions.stream()
                .anyMatch(
                        permission ->
                                switch (permission) {
                                    case OWNER_READ, OWNER_WRITE, OWNER_EXECUTE -> false;
                                    case GROUP_READ,
                                            GROUP_WRITE,
                                            GROUP_EXECUTE,
                                            OTHERS_READ,
                                            OTHERS_WRITE,
                                            OTHERS_EXECUTE ->
                                            true;
                                });
    }

    /**
     * Returns a message which states that other users can access the file, and what the operator
     * must do.
     */
    String openToOthers(Path path) {
        return path
                + " is open to others (mode "
                + PosixFilePermissions.toString(permissions)
                + "); run `chmod 600 "
                + path
                + "`";
    }
}
