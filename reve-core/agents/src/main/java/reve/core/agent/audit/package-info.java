// SPDX-License-Identifier: Apache-2.0
/** The audit record: a file with all messages to clients. */
@NullMarked
package reve.core.agent.audit;

import org.jspecify.annotations.NullMarked;
