// SPDX-License-Identifier: Apache-2.0
/**
 * The page that shows running worlds and controls them: a client of the agent protocol over a
 * WebSocket, and beside it binary messages with the columns that moved.
 */
@NullMarked
package reve.worlds.web;

import org.jspecify.annotations.NullMarked;
