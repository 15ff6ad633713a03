// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.Optional;
import java.util.OptionalLong;

/**
 * The result of an act.
 *
 * @param frame in which the act took effect, if accepted
 * @param code of the refusal, for programs
 * @param reason of the refusal, for people
 */
public record ActResult(
        long id,
        boolean accepted,
        OptionalLong frame,
        Optional<String> code,
        Optional<String> reason)
        implements ServerMessage {}
