// SPDX-License-Identifier: Apache-2.0
/** The demonstration that {@code ./reve demo} runs: a server and two agents, each a process. */
@NullMarked
package reve.worlds.demo;

import org.jspecify.annotations.NullMarked;
