// SPDX-License-Identifier: Apache-2.0
/**
 * The web page that shows and controls running worlds, and the server of this page. The page is a
 * client of the agent protocol over a WebSocket. Additional binary messages contain the changed
 * columns of the scene.
 */
@NullMarked
package reve.worlds.web;

import org.jspecify.annotations.NullMarked;
