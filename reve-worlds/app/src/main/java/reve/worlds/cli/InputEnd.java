// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import java.io.IOException;
import java.io.InputStream;

/**
 * The end of the standard input. A program that starts a command keeps the other end of its input
 * open. The operating system closes it if the program ends, also if it is killed.
 */
final class InputEnd {
    private static final int BYTES = 4096;

    private InputEnd() {}

    /**
     * Reads the standard input, and ignores what it contains.
     *
     * @param stop called on a thread of its own when the input has ended
     */
    static void then(Runnable stop) {
        Thread.ofPlatform()
                .daemon()
                .name("input")
                .start(
                        () -> {
                            await(System.in);
                            stop.run();
                        });
    }

    private static void await(InputStream input) {
        byte[] ignored = new byte[BYTES];
        try {
            while (input.read(ignored) >= 0) {
                // The content has no meaning.
            }
        } catch (IOException ended) {
            // An input that cannot be read has ended.
        }
    }
}
