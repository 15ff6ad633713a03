// SPDX-License-Identifier: Apache-2.0
/** Example agents. */
@NullMarked
package reve.agent.examples;

import org.jspecify.annotations.NullMarked;
