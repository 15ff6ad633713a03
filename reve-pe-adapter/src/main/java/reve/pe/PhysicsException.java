// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.util.OptionalLong;

/**
 * The refusal of a call by an engine, or the failure of a law. The message has one line for each
 * problem: the object concerned, what was found, and what was expected.
 */
public final class PhysicsException extends RuntimeException {
    private static final long serialVersionUID = 1L;

    /** Status that the engine returned. */
    private final Status status;

    /** Id of the library that caused the failure, or 0. */
    private final int libraryId;

    /** Name of the library that caused the failure, or empty. */
    private final String library;

    /** Name of the law that caused the failure, or empty. */
    private final String law;

    /** The property concerned, or empty. */
    private final String property;

    /** Row of the property, or -1. */
    private final long row;

    /**
     * @param libraryId library that caused the failure, or 0
     * @param library its name, or empty
     * @param law law that caused the failure, or empty
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

    /** Creates a refusal without a law and a property. */
    public PhysicsException(Status status, String message) {
        this(status, 0, "", "", "", -1, message);
    }

    /** Returns the kind of failure. */
    public Status status() {
        return status;
    }

    /** Returns the id of the loaded library that caused the failure, or 0. */
    public int libraryId() {
        return libraryId;
    }

    /** Returns the name of the loaded library that caused the failure, or empty. */
    public String library() {
        return library;
    }

    /** Returns the name of the law that caused the failure, or empty. */
    public String law() {
        return law;
    }

    /** Returns the name of the property concerned, or empty. */
    public String property() {
        return property;
    }

    /** Returns the row of {@link #property()}, if one row caused the failure. */
    public OptionalLong row() {
        return row < 0 ? OptionalLong.empty() : OptionalLong.of(row);
    }
}
