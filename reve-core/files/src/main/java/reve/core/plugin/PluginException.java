// SPDX-License-Identifier: Apache-2.0
package reve.core.plugin;

import java.io.Serial;
import java.util.List;

/** Plugins that cannot be used. The exception contains one message for each problem. */
public final class PluginException extends Exception {
    @Serial private static final long serialVersionUID = 1;

    /** The messages; each begins with the name of the folder or jar. */
    private final transient List<String> problems;

    PluginException(List<String> problems) {
        super(String.join("\n", problems));
        this.problems = List.copyOf(problems);
    }

    /** Returns the messages. Each begins with the name of the folder or jar. */
    public List<String> problems() {
        return problems;
    }
}
