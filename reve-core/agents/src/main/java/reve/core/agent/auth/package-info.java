// SPDX-License-Identifier: Apache-2.0
/**
 * How clients and server know each other: tokens and what they open, the files that they are in,
 * and TLS certificates.
 */
@NullMarked
package reve.core.agent.auth;

import org.jspecify.annotations.NullMarked;
