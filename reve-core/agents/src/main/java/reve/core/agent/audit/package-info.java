// SPDX-License-Identifier: Apache-2.0
/** The record of all that clients are sent. */
@NullMarked
package reve.core.agent.audit;

import org.jspecify.annotations.NullMarked;
