// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.Arrays;
import java.util.Locale;
import java.util.Optional;

/** The way in which a new version of a loaded law replaces the old version. */
public enum LawSwap {
    /** Way in which the new version first runs as a trial, in a copy of the world. */
    SHADOW,
    /** Way in which the new version takes over between two frames, without a trial. */
    AT_ONCE;

    /** Finds the constant whose {@link #text} is given. */
    public static Optional<LawSwap> find(String text) {
        return Arrays.stream(values()).filter(one -> one.text().equals(text)).findFirst();
    }

    /** Returns the name of this constant in options and messages, such as "at-once". */
    public String text() {
        return name().toLowerCase(Locale.ROOT).replace('_', '-');
    }
}
