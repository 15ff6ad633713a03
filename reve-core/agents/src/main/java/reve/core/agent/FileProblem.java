// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import java.util.Optional;
import java.util.function.Supplier;

/**
 * Reports problems with one of the server's files to the operator. A report is sent when a problem
 * begins, changes or ends.
 */
final class FileProblem {

    private final String source;
    private final Supplier<Optional<String>> problem;
    private final Supplier<String> solved;
    private final ServerProblems listener;
    private Optional<String> reported = Optional.empty();

    /**
     * @param problem returns a message about the present problem; empty if there is none
     * @param solved returns the message for the operator when a problem has ended
     */
    FileProblem(
            String source,
            Supplier<Optional<String>> problem,
            Supplier<String> solved,
            ServerProblems listener) {
        this.source = source;
        this.problem = problem;
        this.solved = solved;
        this.listener = listener;
    }

    /**
     * Reports to the operator if the problem has begun, changed or ended since the last call.
     * Called periodically by one thread at a time.
     */
    void check() {
        Optional<String> now = problem.get();
        if (!now.equals(reported)) {
            reported = now;
            listener.report(source, now.orElseGet(solved));
        }
    }
}
