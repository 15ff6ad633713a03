// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import reve.worlds.Product;

import java.io.IOException;
import java.io.InputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.List;

/** The layers of protection that the sandbox of laws has on this machine. */
final class SandboxLayers {
    private SandboxLayers() {}

    /**
     * Returns one line for each layer that this machine lacks. Each line contains the reason that
     * the operating system gives. Blocks for a few milliseconds.
     */
    static List<String> missing() {
        Path program = Product.nativeFolder().resolve("vesper-sandbox");
        try {
            Process check =
                    new ProcessBuilder(program.toString(), "--check")
                            .redirectErrorStream(true)
                            .start();
            check.getOutputStream().close();
            String text;
            try (InputStream output = check.getInputStream()) {
                text = new String(output.readAllBytes(), StandardCharsets.UTF_8);
            }
            List<String> lines = text.lines().filter(line -> line.contains(": no")).toList();
            int code = check.waitFor();
            return code == 0 || !lines.isEmpty()
                    ? lines
                    : List.of(program + " ended with code " + code + ": " + text.strip());
        } catch (IOException unfit) {
            return List.of(program + " cannot be started: " + unfit.getMessage());
        } catch (InterruptedException e) {
            Thread.currentThread().interrupt();
            return List.of(program + " was interrupted");
        }
    }
}
