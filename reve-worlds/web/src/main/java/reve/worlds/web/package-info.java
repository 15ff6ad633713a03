// SPDX-License-Identifier: Apache-2.0
/**
 * The web page that shows and controls running worlds, and its server. The page is a client of the
 * agent protocol over a WebSocket; binary messages beside it contain the changed columns of the
 * scene.
 */
@NullMarked
package reve.worlds.web;

import org.jspecify.annotations.NullMarked;
