// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.Optional;
import java.util.OptionalLong;

/**
 * The result of an act or a command.
 *
 * @param frame number of the frame in which the act took effect, if it was accepted
 * @param code code of the refusal, for programs
 * @param reason reason for the refusal, for people
 * @param value the answer to a question: a List or Map of texts, numbers, truth values, lists and
 *     maps
 */
public record ActResult(
        long id,
        boolean accepted,
        OptionalLong frame,
        Optional<String> code,
        Optional<String> reason,
        Optional<Object> value)
        implements ServerMessage {}
