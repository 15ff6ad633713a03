// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

/**
 * The columns of bodies in frames of the scene that are sent to web pages. The script page/view.js
 * reads them.
 */
enum SceneColumns {
    /** Position of the body's origin [m]. */
    POSITION("position", 3, 0),
    /** Unit quaternion xyzw. */
    ORIENTATION("orientation", 4, 0),
    /** Extents along the body's own axes [m]. */
    SIZE("size", 3, 0),
    /** Bytes r g b a. */
    COLOUR("colour", 1, 0),
    /** Velocity [m/s]. Sent only on request. */
    VELOCITY("velocity", 3, 1),
    /** Sum of the forces of laws [N]. Sent only on request. */
    FORCE("externalForce", 3, 2);

    /** The bits of all columns that are sent only on request. */
    static final int ALL_OPTIONAL = 3;

    private final String property;
    private final int components;
    private final int bit;

    SceneColumns(String property, int components, int bit) {
        this.property = property;
        this.components = components;
        this.bit = bit;
    }

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
