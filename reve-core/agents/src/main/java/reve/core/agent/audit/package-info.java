// SPDX-License-Identifier: Apache-2.0
/** The record of all messages to clients. */
@NullMarked
package reve.core.agent.audit;

import org.jspecify.annotations.NullMarked;
