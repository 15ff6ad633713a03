// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

/**
 * The columns of bodies in frames of the scene that are sent to web pages. The script page/view.js
 * reads them.
 */
enum SceneColumns {
    /** Column of the position of the body's origin [m]. */
    POSITION("position", 3, 0),
    /** Column of the orientation, a unit quaternion xyzw. */
    ORIENTATION("orientation", 4, 0),
    /** Column of the extents along the body's own axes [m]. */
    SIZE("size", 3, 0),
    /** Column of the colour as bytes r g b a. */
    COLOUR("colour", 1, 0),
    /** Column of the velocity [m/s]. It is sent only on request. */
    VELOCITY("velocity", 3, 1),
    /** Column of the sum of the forces of laws [N]. It is sent only on request. */
    FORCE("externalForce", 3, 2),
    /**
     * Column of the number of contacts of the body that have begun since the first request, and of
     * the force of the newest of them [N], see {@link Contacts}. It is sent only on request.
     */
    CONTACTS("", 2, SceneColumns.CONTACTS_BIT);

    /** The bit of the column of contacts. */
    static final int CONTACTS_BIT = 4;

    /** The bits of all columns that are sent only on request. */
    static final int ALL_OPTIONAL = 7;

    private final String property;
    private final int components;
    private final int bit;

    SceneColumns(String property, int components, int bit) {
        this.property = property;
        this.components = components;
        this.bit = bit;
    }

    /** Returns the property of bodies; empty if the scene computes the column. */
    String property() {
        return property;
    }

    int components() {
        return components;
    }

    /** Returns whether a page that requested these optional columns receives this column. */
    boolean isWanted(int requested) {
        return bit == 0 || (requested & bit) != 0;
    }
}
