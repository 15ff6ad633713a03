// SPDX-License-Identifier: Apache-2.0
/**
 * The agents in a world and their bodies, and the check and execution of their inputs. The world's
 * thread.
 */
@NullMarked
package reve.core.agent.embodiment;

import org.jspecify.annotations.NullMarked;
