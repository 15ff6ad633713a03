// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.Optional;
import java.util.OptionalLong;

/**
 * How an act ended.
 *
 * @param frame in which it took effect, if accepted
 * @param code why it was refused, for programs
 * @param reason and for people
 */
public record ActResult(
        long id,
        boolean accepted,
        OptionalLong frame,
        Optional<String> code,
        Optional<String> reason)
        implements ServerMessage {}
