// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.nio.charset.StandardCharsets;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/** Checks of a file with laws in Python, before an engine loads it. */
public final class PythonLaw {
    private static final Pattern FIRST =
            Pattern.compile(
                    "^@vesper\\.(?:law|field)\\b.*?^def\\s+(\\w{1,47})",
                    Pattern.DOTALL | Pattern.MULTILINE);

    private PythonLaw() {}

    /**
     * Returns the name of the first law or field of a file. It serves as the name of a file whose
     * path is unknown.
     */
    public static String nameOf(byte[] file) {
        Matcher first = FIRST.matcher(new String(file, StandardCharsets.UTF_8));
        return (first.find() ? first.group(1) : "law") + PreparedLibrary.PYTHON_ENDING;
    }

    /**
     * Returns the exception that an engine in the client's own process throws. Laws in Python are
     * not permitted in this process.
     */
    public static PhysicsException refusedHere(String file) {
        return new PhysicsException(
                Status.LIBRARY_LOAD_FAILED,
                file
                        + " is in Python, and laws in Python run only in the engine's own process:"
                        + " remove --engine in-process, or write the law as text");
    }

    /**
     * Refuses a file that has neither a law nor a field.
     *
     * @throws PhysicsException naming the file
     */
    public static void requireLaw(String file, byte[] bytes) {
        if (!PreparedLibrary.isPython(bytes)) {
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED,
                    file
                            + ": no line begins with "
                            + String.join(" or ", PreparedLibrary.PYTHON_SIGNS)
                            + ", expected a function behind such a line, see"
                            + " docs/laws-in-python.md");
        }
    }
}
