package reve.core.mesh;

import java.net.URI;
import java.net.URISyntaxException;
import java.nio.ByteBuffer;
import java.util.Base64;
import java.util.HashMap;
import java.util.Map;
import java.util.Optional;
import reve.core.world.Texture;

/** What a mesh file refers to: files beside it and below, or data in itself. */
final class Sources {

    private static final int MAX_BYTES = 64 << 20;

    private final WorldFolder folder;
    private final String path;
    private final Budget budget;
    private final Map<String, Texture> images = new HashMap<>();

    /** @param path of the mesh file, relative to the folder */
    Sources(WorldFolder folder, String path, Budget budget) {
        this.folder = folder;
        this.path = path;
        this.budget = budget;
    }

    /** The mesh file's path, which all messages begin with. */
    String path() {
        return path;
    }

    Budget budget() {
        return budget;
    }

    AssetException refuse(String reason) {
        return new AssetException(path + ": " + reason);
    }

    /** The bytes behind a URI: base64 data, or a file named relative to the mesh file. */
    ByteBuffer read(String uri) throws AssetException {
        if (!uri.startsWith("data:")) {
            return ByteBuffer.wrap(folder.read(beside(decode(uri)), MAX_BYTES));
        }
        int comma = uri.indexOf(',');
        if (comma < 0 || !uri.substring(0, comma).endsWith(";base64")) {
            throw refuse("a data URI that is not base64");
        }
        try {
            return ByteBuffer.wrap(Base64.getDecoder().decode(uri.substring(comma + 1)));
        } catch (IllegalArgumentException broken) {
            throw refuse("a data URI with broken base64: " + broken.getMessage());
        }
    }

    /** The image of a file named relative to the mesh file. */
    Texture image(String name) throws AssetException {
        String file = beside(name);
        Texture image = images.get(file);
        if (image == null) {
            image = ImageDecoder.decode(folder.read(file, MAX_BYTES), file, Optional.empty(),
                    budget);
            images.put(file, image);
        }
        return image;
    }

    /** The bytes of a file named relative to the mesh file. */
    byte[] file(String name, int maxBytes) throws AssetException {
        return folder.read(beside(name), maxBytes);
    }

    private String beside(String name) {
        return path.substring(0, path.lastIndexOf('/') + 1) + name;
    }

    private String decode(String uri) throws AssetException {
        try {
            URI parsed = new URI(uri);
            if (parsed.getScheme() == null && parsed.getAuthority() == null
                    && parsed.getPath() != null && !parsed.getPath().startsWith("/")) {
                return parsed.getPath();
            }
        } catch (URISyntaxException broken) {
            throw refuse("refers to `" + shorten(uri) + "`, which is no URI");
        }
        throw refuse("refers to `" + shorten(uri)
                + "`, expected a file beside it, or data within it");
    }

    private static String shorten(String text) {
        return text.length() <= 64 ? text : text.substring(0, 63) + "…";
    }
}
