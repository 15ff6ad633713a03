package reve.core.mesh;

/** How much all assets of one world may take together. */
final class Budget {

    private static final long MAX_VERTICES = 1 << 22;
    private static final long MAX_PIXELS = 1 << 25;

    private long vertices;
    private long pixels;

    void takeVertices(String path, long count) throws AssetException {
        vertices += count;
        if (vertices > MAX_VERTICES) {
            throw new AssetException(path + ": the meshes of this world have more than "
                    + MAX_VERTICES + " vertices together");
        }
    }

    void takePixels(String path, long count) throws AssetException {
        pixels += count;
        if (pixels > MAX_PIXELS) {
            throw new AssetException(path + ": the textures of this world have more than "
                    + MAX_PIXELS + " pixels together");
        }
    }
}
