// SPDX-License-Identifier: Apache-2.0
/** Authentication: tokens, their rights, the files that store them, and TLS certificates. */
@NullMarked
package reve.core.agent.auth;

import org.jspecify.annotations.NullMarked;
