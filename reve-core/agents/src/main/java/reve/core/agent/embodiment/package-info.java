// SPDX-License-Identifier: Apache-2.0
/** The bodies of agents; checks and applies agents' inputs. The world's thread. */
@NullMarked
package reve.core.agent.embodiment;

import org.jspecify.annotations.NullMarked;
