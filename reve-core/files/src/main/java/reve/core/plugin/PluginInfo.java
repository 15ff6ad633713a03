// SPDX-License-Identifier: Apache-2.0
package reve.core.plugin;

import java.util.Optional;

/**
 * The identity of a plugin. Recordings and stores contain it.
 *
 * @param file name of the jar
 * @param sha256 hash of the jar, in hexadecimal digits
 * @param version the attribute {@code Implementation-Version} of the jar's manifest
 */
public record PluginInfo(String file, String sha256, Optional<String> version) {
    private static final int SHOWN_DIGITS = 12;

    /** Returns the name, the version if there is one, and the first digits of the hash. */
    @Override
    public String toString() {
        return file
                + version.map(text -> " " + text).orElse("")
                + " (SHA-256 "
                + sha256.substring(0, Math.min(SHOWN_DIGITS, sha256.length()))
                + "…)";
    }
}
