// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.util.OptionalLong;

/**
 * An engine refused a call or a law failed. The message is one line for each, that names the thing,
 * what was found and what was expected.
 */
public final class PhysicsException extends RuntimeException {
    private static final long serialVersionUID = 1L;

    private final Status status;
    private final int libraryId;
    private final String library;
    private final String law;
    private final String property;
    private final long row;

    /**
     * @param libraryId the library to blame, or 0
     * @param library its name, or empty
     * @param law the law to blame, or empty
     * @param property the property concerned, or empty
     * @param row row of that property, or -1
     */
    public PhysicsException(
            Status status,
            int libraryId,
            String library,
            String law,
            String property,
            long row,
            String message) {
        super(message);
        this.status = status;
        this.libraryId = libraryId;
        this.library = library;
        this.law = law;
        this.property = property;
        this.row = row;
    }

    /** A refusal that concerns no law and no property. */
    public PhysicsException(Status status, String message) {
        this(status, 0, "", "", "", -1, message);
    }

    /** What kind of failure it is. */
    public Status status() {
        return status;
    }

    /** Id of the loaded library to blame, or 0. */
    public int libraryId() {
        return libraryId;
    }

    /** Name of the library to blame, or empty. */
    public String library() {
        return library;
    }

    /** Name of the law to blame, or empty. */
    public String law() {
        return law;
    }

    /** Name of the property concerned, or empty. */
    public String property() {
        return property;
    }

    /** Row of {@link #property()}, if one row is to blame. */
    public OptionalLong row() {
        return row < 0 ? OptionalLong.empty() : OptionalLong.of(row);
    }
}
