package reve.core.world;

/**
 * An action was refused; the world is as it was before. The code is for programs and never
 * changes its meaning, the message is for people.
 */
public final class ActionRefused extends Exception {
    private static final long serialVersionUID = 1L;

    private final String code;

    public ActionRefused(String code, String message) {
        super(message);
        this.code = code;
    }

    /** A short lower-case name of the reason, such as {@code missing-argument}. */
    public String code() {
        return code;
    }
}
