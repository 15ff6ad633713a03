// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

class RoundTripTest {
    private static final long SECOND = 1_000_000_000;

    private final RoundTrip trip = new RoundTrip(15 * SECOND);

    @Test
    void thePongEndsTheMeasurementThatThePingBegan() {
        assertThat(trip.seconds()).isEmpty();
        assertThat(trip.begin(5 * SECOND)).isTrue();
        assertThat(trip.seconds()).isEmpty();
        trip.end(5 * SECOND + 30_000_000);
        assertThat(trip.seconds()).hasValue(0.03);
    }

    @Test
    void oneMeasurementRunsAtATimeAndThereIsASecondBetweenTwo() {
        assertThat(trip.begin(0)).isTrue();
        assertThat(trip.begin(2 * SECOND)).isFalse();
        trip.end(3 * SECOND);
        assertThat(trip.begin(4 * SECOND - 1)).isFalse();
        assertThat(trip.begin(4 * SECOND)).isTrue();
        trip.end(4 * SECOND + 7_000_000);
        assertThat(trip.seconds()).hasValue(0.007);
    }

    @Test
    void aClientThatAnswersPingsByOtherMessagesIsMeasuredAgain() {
        assertThat(trip.begin(0)).isTrue();
        assertThat(trip.begin(15 * SECOND)).isTrue();
        trip.end(15 * SECOND + 1_000_000);
        assertThat(trip.seconds()).hasValue(0.001);
    }

    @Test
    void aPongThatAnswersNothingMeasuresNothing() {
        trip.end(SECOND);
        assertThat(trip.seconds()).isEmpty();
        trip.begin(2 * SECOND);
        trip.end(2 * SECOND + 5_000_000);
        trip.end(9 * SECOND);
        assertThat(trip.seconds()).hasValue(0.005);
    }
}
