// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import reve.core.text.Visible;

/** Escaping of texts for HTML pages. */
final class Html {
    private Html() {}

    /** Escapes a text, so that no character has a meaning in HTML, also inside an attribute. */
    static String text(String text) {
        return Visible.line(text)
                .replace("&", "&amp;")
                .replace("<", "&lt;")
                .replace(">", "&gt;")
                .replace("\"", "&quot;")
                .replace("'", "&#39;");
    }
}
