// SPDX-License-Identifier: Apache-2.0
/** The interface of a running world for the agent server. The application implements it. */
@NullMarked
package reve.core.agent.port;

import org.jspecify.annotations.NullMarked;
