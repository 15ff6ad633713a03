package reve.worlds;

/** What this build calls itself. */
public final class Product {
    public static final String VERSION = "0.1.0";

    private Product() {}
}
