// SPDX-License-Identifier: Apache-2.0
/** What a running world gives to the server of its agents. The application implements it. */
@NullMarked
package reve.core.agent.port;

import org.jspecify.annotations.NullMarked;
