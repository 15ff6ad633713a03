// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import reve.core.world.Texture;

import java.net.URI;
import java.net.URISyntaxException;
import java.nio.ByteBuffer;
import java.nio.file.Path;
import java.util.Base64;
import java.util.HashMap;
import java.util.Map;

/**
 * Reader of the data to which a mesh file refers. These are other files in the folder of the mesh
 * file or below, or base64 data inside the mesh file.
 */
final class Sources {

    private static final int MAX_BYTES = 64 << 20;

    private final AssetFiles files;
    private final String path;

    /** Content of each file that was read for this mesh, by real path. */
    private final Map<Path, byte[]> read = new HashMap<>();

    /**
     * @param path path of the mesh file, relative to the world's folder
     */
    Sources(AssetFiles files, String path) {
        this.files = files;
        this.path = path;
    }

    /** Returns the mesh file's path. All messages begin with it. */
    String path() {
        return path;
    }

    Budget budget() {
        return files.budget();
    }

    AssetException refuse(String reason) {
        return new AssetException(path + ": " + reason);
    }

    /** Returns the data of a URI: base64 data, or a file relative to the mesh file. */
    ByteBuffer read(String uri) throws AssetException {
        if (!uri.startsWith("data:")) {
            return ByteBuffer.wrap(file(decode(uri), MAX_BYTES));
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

    /** Returns the image in the file that a URI names. */
    Texture imageBehind(String uri) throws AssetException {
        return image(decode(uri));
    }

    /** Returns the image in a file whose name is relative to the mesh file. */
    Texture image(String name) throws AssetException {
        return files.imageOfMesh(beside(name));
    }

    /**
     * Returns the bytes of a file whose name is relative to the mesh file. Reads each file once.
     */
    byte[] file(String name, int maxBytes) throws AssetException {
        Path real = files.find(beside(name));
        byte[] bytes = read.get(real);
        if (bytes == null) {
            bytes = files.read(beside(name), maxBytes);
            read.put(real, bytes);
        }
        return bytes;
    }

    private String beside(String name) {
        return path.substring(0, path.lastIndexOf('/') + 1) + name;
    }

    private String decode(String uri) throws AssetException {
        try {
            URI parsed = new URI(uri);
            if (parsed.getScheme() == null
                    && parsed.getAuthority() == null
                    && parsed.getPath() != null
                    && !parsed.getPath().startsWith("/")) {
                return parsed.getPath();
            }
        } catch (URISyntaxException broken) {
            throw refuse("refers to `" + shorten(uri) + "`, which is no URI");
        }
        throw refuse(
                "refers to `" + shorten(uri) + "`, expected a file beside it, or data within it");
    }

    private static String shorten(String text) {
        return text.length() <= 64 ? text : text.substring(0, 63) + "…";
    }
}
