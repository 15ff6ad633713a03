// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import java.util.List;

/** The project's own scripts of the web page. */
final class OwnScripts {

    /** Names of the files, in alphabetical order. */
    static final List<String> NAMES =
            List.of(
                    "agents.js",
                    "audit.js",
                    "camera.js",
                    "connection.js",
                    "dom.js",
                    "item.js",
                    "laws.js",
                    "lawtext.js",
                    "main.js",
                    "nodes.js",
                    "plots.js",
                    "scene.js",
                    "sound.js",
                    "steer.js",
                    "transport.js",
                    "view.js");

    private OwnScripts() {}
}
