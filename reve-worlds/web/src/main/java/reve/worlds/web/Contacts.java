// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.jspecify.annotations.Nullable;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.Comparator;
import java.util.List;

/**
 * Finds the contacts that begin in a world, from the contact forces on bodies in successive frames.
 * A contact begins when the force on a body rises to a multiple of the forces shortly before. Its
 * force is the largest force until the force no longer rises. Bodies that only lie on each other
 * begin no contacts. For one thread.
 */
final class Contacts {

    /** Receiver of the contacts that begin. */
    interface Listener {
        /**
         * @param slot slot of the body
         * @param newtons largest force at the beginning of the contact [N]
         */
        void began(int slot, double newtons);
    }

    /** A contact begins when the force is more than this multiple of the {@link #usual} one. */
    private static final double RISE = 4;

    /** Time in which the {@link #usual} force falls to 1/e after the end of a contact [s]. */
    private static final double DECAY_SECONDS = 0.1;

    /**
     * Smallest factor of the {@link #usual} force between two frames. It is larger than 1 / {@link
     * #RISE}, so that a body at rest begins no contacts, however long a frame is.
     */
    private static final double LEAST_KEPT = 0.5;

    /**
     * Two bodies whose forces cancel except for this fraction touch each other, and have one
     * contact.
     */
    private static final double UNEQUAL = 0.01;

    private static final int FIRST_SLOTS = 64;

    private static final class Beginning {
        private final int slot;
        private double newtons;
        private double x;
        private double y;
        private double z;

        Beginning(int slot) {
            this.slot = slot;
        }

        void set(double newNewtons, double newX, double newY, double newZ) {
            newtons = newNewtons;
            x = newX;
            y = newY;
            z = newZ;
        }

        boolean cancels(Beginning other) {
            return Math.hypot(Math.hypot(x + other.x, y + other.y), z + other.z)
                    <= UNEQUAL * newtons;
        }
    }

    /**
     * By slot: the largest force of the last frames, which decays [N]; NaN for a slot whose force
     * was not read yet.
     */
    private double[] usual = unknown(FIRST_SLOTS);

    /** By slot: the contact whose force still rises; null if there is none. */
    private @Nullable Beginning[] rising = new Beginning[FIRST_SLOTS];

    private double lastSeconds = Double.NaN;

    private static double[] unknown(int slots) {
        double[] none = new double[slots];
        Arrays.fill(none, Double.NaN);
        return none;
    }

    /** Forgets the forces on the body of a slot, because another item has the slot now. */
    void forget(int slot) {
        if (slot < usual.length) {
            usual[slot] = Double.NaN;
            rising[slot] = null;
        }
    }

    /**
     * Reads the forces of a frame.
     *
     * @param seconds time of the world [s]; an earlier time than before means that the world was
     *     rewound
     * @param rows number of bodies
     * @param slotOfRow the slot of each body, or -1
     * @param forces the contact forces on the bodies, three numbers for each [N]
     * @param listener receives the contacts whose force no longer rises, the strongest first
     */
    void read(double seconds, int rows, int[] slotOfRow, double[] forces, Listener listener) {
        if (!(seconds >= lastSeconds)) {
            Arrays.fill(usual, Double.NaN);
            Arrays.fill(rising, null);
        }
        double kept = Math.max(LEAST_KEPT, Math.exp((lastSeconds - seconds) / DECAY_SECONDS));
        lastSeconds = seconds;
        List<Beginning> begun = new ArrayList<>();
        for (int row = 0; row < rows; row++) {
            int slot = slotOfRow[row];
            if (slot < 0) {
                continue;
            }
            grow(slot + 1);
            double x = forces[3 * row];
            double y = forces[3 * row + 1];
            double z = forces[3 * row + 2];
            double newtons = Math.hypot(Math.hypot(x, y), z);
            Beginning contact = rising[slot];
            if (contact != null && newtons > contact.newtons) {
                contact.set(newtons, x, y, z);
            } else if (contact != null) {
                begun.add(contact);
                rising[slot] = null;
            } else if (newtons > RISE * kept * usual[slot]) { // false for NaN
                contact = new Beginning(slot);
                contact.set(newtons, x, y, z);
                rising[slot] = contact;
            }
            double before = usual[slot];
            usual[slot] = Double.isNaN(before) ? newtons : Math.max(newtons, kept * before);
        }
        tell(begun, listener);
    }

    private static void tell(List<Beginning> begun, Listener listener) {
        begun.sort(
                Comparator.comparingDouble((Beginning contact) -> -contact.newtons)
                        .thenComparingInt(contact -> contact.slot));
        boolean[] told = new boolean[begun.size()];
        for (int i = 0; i < told.length; i++) {
            if (told[i]) {
                continue;
            }
            Beginning contact = begun.get(i);
            listener.began(contact.slot, contact.newtons);
            for (int j = i + 1;
                    j < told.length && begun.get(j).newtons >= (1 - UNEQUAL) * contact.newtons;
                    j++) {
                if (!told[j] && contact.cancels(begun.get(j))) {
                    told[j] = true;
                    break;
                }
            }
        }
    }

    private void grow(int slots) {
        if (slots > usual.length) {
            int before = usual.length;
            int room = Math.max(slots, 2 * before);
            usual = Arrays.copyOf(usual, room);
            Arrays.fill(usual, before, room, Double.NaN);
            rising = Arrays.copyOf(rising, room);
        }
    }
}
