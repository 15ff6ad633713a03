// SPDX-License-Identifier: Apache-2.0
/**
 * The agents in a world and their bodies, and the check and execution of their inputs. All classes
 * of this package run on the world's thread.
 */
@NullMarked
package reve.core.agent.embodiment;

import org.jspecify.annotations.NullMarked;
