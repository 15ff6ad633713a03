// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import java.util.ArrayList;
import java.util.List;

class ContactsTest {
    private static final int[] SLOTS = {4, 70};

    private final Contacts contacts = new Contacts();
    private final List<String> begun = new ArrayList<>();
    private double seconds;
    private double frame = 1.0 / 60;

    /** Makes a frame in which these forces along Y act on the bodies [N]. */
    private void forces(double first, double second) {
        seconds += frame;
        read(first, second);
    }

    private void read(double first, double second) {
        contacts.read(
                seconds,
                2,
                SLOTS,
                new double[] {0, first, 0, 0, second, 0},
                (slot, newtons) -> begun.add(slot + ": " + newtons));
    }

    private void rest(int frames, double force) {
        for (int i = 0; i < frames; i++) {
            forces(force, 0);
        }
    }

    @Test
    void anImpulseOfOneFrameIsOneContact() {
        rest(3, 0);
        forces(531, 0);
        assertThat(begun).isEmpty();
        rest(30, 0);
        assertThat(begun).containsExactly("4: 531.0");
        forces(400, 0);
        rest(1, 0);
        assertThat(begun).containsExactly("4: 531.0", "4: 400.0");
    }

    @Test
    void aContactWhoseForceRisesHasItsLargestForce() {
        rest(2, 0);
        for (double force : new double[] {1, 5, 9, 8, 8, 9, 8}) {
            forces(force, 0);
        }
        rest(20, 8);
        assertThat(begun).containsExactly("4: 9.0");
    }

    @Test
    void aBodyAtRestBeginsNoContacts() {
        rest(1, 20);
        for (int i = 0; i < 60; i++) {
            forces(20, 0);
            rest(i % 4, 0); // a solver may keep a body apart from the floor for some frames
        }
        frame = 2; // frames of two seconds
        rest(10, 20);
        assertThat(begun).isEmpty();
        forces(90, 0);
        rest(2, 20);
        assertThat(begun).containsExactly("4: 90.0");
    }

    @Test
    void twoBodiesThatMeetHaveOneContactAndOthersOneEach() {
        rest(2, 0);
        forces(50, -50);
        rest(60, 0);
        assertThat(begun).containsExactly("4: 50.0");
        begun.clear();
        forces(50, -60);
        rest(60, 0);
        assertThat(begun).containsExactly("70: 60.0", "4: 50.0");
        begun.clear();
        forces(50, 50);
        rest(1, 0);
        assertThat(begun).containsExactly("4: 50.0", "70: 50.0");
    }

    @Test
    void forcesThatWereThereBeforeTheFirstFrameAreNoContacts() {
        rest(5, 20);
        assertThat(begun).isEmpty();
        contacts.forget(SLOTS[0]); // another item has the slot now
        rest(5, 500);
        assertThat(begun).isEmpty();
        seconds = 0; // a rewind
        read(9000, 0);
        rest(5, 0);
        assertThat(begun).isEmpty();
    }
}
