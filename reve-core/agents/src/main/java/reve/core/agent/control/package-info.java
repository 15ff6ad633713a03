// SPDX-License-Identifier: Apache-2.0
/**
 * Execution of clients' commands to a world, and of operators' commands for saved states:
 * rewinding, saving, forking.
 */
@NullMarked
package reve.core.agent.control;

import org.jspecify.annotations.NullMarked;
