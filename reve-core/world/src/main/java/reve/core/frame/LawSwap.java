// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.Arrays;
import java.util.Locale;
import java.util.Optional;

/** How a new version of a loaded law takes over. */
public enum LawSwap {
    /** After a trial in a copy of the world that runs beside it. */
    SHADOW,
    /** Between two frames, without a trial. */
    AT_ONCE;

    /** Returns the way with this name. */
    public static Optional<LawSwap> find(String text) {
        return Arrays.stream(values()).filter(one -> one.text().equals(text)).findFirst();
    }

    /** Returns the name in options and messages, such as "at-once". */
    public String text() {
        return name().toLowerCase(Locale.ROOT).replace('_', '-');
    }
}
