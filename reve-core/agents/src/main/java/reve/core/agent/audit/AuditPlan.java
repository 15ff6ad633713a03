// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.audit;

import java.nio.file.Path;

/**
 * Settings of the audit record.
 *
 * @param file path of the file to which records are appended
 * @param maxBytes size at which the file becomes {@code FILE.1} and a new one begins [bytes]
 * @param keep number of older files {@code FILE.1} to {@code FILE.keep}
 * @param required whether clients are disconnected if messages cannot be recorded; otherwise the
 *     server continues without the record
 */
public record AuditPlan(Path file, long maxBytes, int keep, boolean required) {

    public static final long DEFAULT_BYTES = 64L * 1024 * 1024;
    public static final int DEFAULT_KEEP = 8;

    /**
     * Checks the size and the number of files.
     *
     * @throws IllegalArgumentException if the size is less than 1 byte or no file is kept
     */
    public AuditPlan {
        if (maxBytes < 1 || keep < 1) {
            throw new IllegalArgumentException(
                    "an audit record of "
                            + maxBytes
                            + " bytes and "
                            + keep
                            + " older files, expected 1 or more of each");
        }
    }

    /**
     * Returns the end of a report to the operator. It states what happens while messages cannot be
     * recorded.
     */
    String consequence() {
        return required
                ? "; clients are disconnected until it can"
                : "; they are served without a record";
    }

    /**
     * Returns a plan with the default limits. With this plan the server continues if the record
     * cannot be written.
     */
    public static AuditPlan of(Path file) {
        return new AuditPlan(file, DEFAULT_BYTES, DEFAULT_KEEP, false);
    }
}
