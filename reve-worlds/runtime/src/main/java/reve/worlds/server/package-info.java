// SPDX-License-Identifier: Apache-2.0
/**
 * Running worlds. This package builds them from world files, and connects them to agents, journals,
 * pictures and a watched laws folder.
 */
@NullMarked
package reve.worlds.server;

import org.jspecify.annotations.NullMarked;
