// SPDX-License-Identifier: Apache-2.0
/** Agents worth watching. */
@NullMarked
package reve.agent.examples;

import org.jspecify.annotations.NullMarked;
