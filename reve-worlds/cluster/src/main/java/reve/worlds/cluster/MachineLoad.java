// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import com.sun.management.OperatingSystemMXBean;

import java.io.IOException;
import java.lang.management.ManagementFactory;
import java.nio.file.Files;
import java.nio.file.Path;

/** The load of the machine on which this process runs. For one thread. */
final class MachineLoad {
    private static final Path MEMORY = Path.of("/proc/meminfo");

    private final OperatingSystemMXBean system =
            (OperatingSystemMXBean) ManagementFactory.getOperatingSystemMXBean();

    /**
     * Returns the share of the processors that all programs have used since the last call, 0 to 1.
     */
    double cpu() {
        double load = system.getCpuLoad();
        return load >= 0 ? Math.min(1, load) : 0; // it is negative or NaN before it is known
    }

    /**
     * Returns the share of the memory that all programs use, 0 to 1. Memory that the disk cache can
     * free counts as free.
     */
    double memory() {
        try {
            return memory(Files.readString(MEMORY));
        } catch (IOException unknown) {
            return 0;
        }
    }

    /**
     * @param text content of /proc/meminfo
     */
    static double memory(String text) {
        double total = 0;
        double available = 0;
        for (String line : text.split("\n")) {
            if (line.startsWith("MemTotal:")) {
                total = kibibytes(line);
            } else if (line.startsWith("MemAvailable:")) {
                available = kibibytes(line);
            }
        }
        return total > 0 ? Math.clamp(1 - available / total, 0, 1) : 0;
    }

    private static double kibibytes(String line) {
        return Double.parseDouble(line.replaceAll("[^0-9]", ""));
    }
}
