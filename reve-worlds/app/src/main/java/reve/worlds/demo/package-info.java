// SPDX-License-Identifier: Apache-2.0
/** The demonstration of {@code ./reve demo}: a server and two agents, each in its own process. */
@NullMarked
package reve.worlds.demo;

import org.jspecify.annotations.NullMarked;
