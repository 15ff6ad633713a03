// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

/** The columns of bodies in frames of the scene; page/view.js reads them. */
enum SceneColumns {
    /** Place of the origin [m]. */
    POSITION("position", 3, 0),
    /** Unit quaternion xyzw. */
    ORIENTATION("orientation", 4, 0),
    /** Extents along the own axes [m]. */
    SIZE("size", 3, 0),
    /** Bytes r g b a. */
    COLOUR("colour", 1, 0),
    /** Velocity [m/s], on request. */
    VELOCITY("velocity", 3, 1),
    /** Sum of the forces of laws [N], on request. */
    FORCE("externalForce", 3, 2);

    /** All bits of columns that are sent on request only. */
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

    /** Returns whether the column is among the requested ones. */
    boolean isWanted(int requested) {
        return bit == 0 || (requested & bit) != 0;
    }
}
