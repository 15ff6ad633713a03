// SPDX-License-Identifier: Apache-2.0
/**
 * Servers in a cluster: their nodes share the worlds of a database. Apache Pekko decides which node
 * runs a world. The epochs of the database decide which node may write it.
 */
@NullMarked
package reve.worlds.cluster;

import org.jspecify.annotations.NullMarked;
