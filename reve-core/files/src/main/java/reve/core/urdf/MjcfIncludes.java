// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.mesh.AssetException;
import reve.core.mesh.WorldFolder;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.HashSet;
import java.util.List;
import java.util.Set;

/**
 * The files that an MJCF file includes. Their paths are relative to the folder of the first file
 * and must not leave this folder.
 */
final class MjcfIncludes {
    private static final int MAX_FILES = 100;
    private static final long MAX_BYTES = 16L << 20;

    private final WorldFolder folder;
    private final String prefix;
    private final Set<Path> read = new HashSet<>();
    private long bytes;

    private MjcfIncludes(Path file, String prefix) {
        Path parent = file.getParent();
        this.folder = new WorldFolder(parent == null ? file : parent);
        this.prefix = prefix;
        read.add(file.normalize());
    }

    /**
     * Returns the root element of a file. The children of each included file replace the element
     * {@code include}.
     *
     * @param file absolute path of the file
     */
    static XmlElement expand(XmlElement root, Path file) throws IOException, RobotFileException {
        String name = root.file();
        int end = Math.max(name.lastIndexOf('/'), name.lastIndexOf('\\')) + 1;
        return new MjcfIncludes(file, name.substring(0, end)).expanded(root);
    }

    private XmlElement expanded(XmlElement element) throws IOException, RobotFileException {
        List<XmlElement> children = new ArrayList<>();
        for (XmlElement child : element.children()) {
            if (child.name().equals("include")) {
                children.addAll(expanded(included(child)).children());
            } else {
                children.add(expanded(child));
            }
        }
        return new XmlElement(
                element.file(), element.line(), element.name(), element.attributes(), children);
    }

    private XmlElement included(XmlElement include) throws IOException, RobotFileException {
        String name = include.text("file");
        Path file;
        try {
            file = folder.find(name);
        } catch (AssetException refused) {
            throw include.problem(refused.getMessage());
        }
        if (!read.add(file.toAbsolutePath().normalize())) {
            throw include.problem(
                    "the file " + name + " is included twice; a file may be included once");
        }
        bytes += Files.size(file);
        if (read.size() > MAX_FILES || bytes > MAX_BYTES) {
            throw include.problem(
                    "the included files are more than " + MAX_FILES + ", or larger than 16 MiB");
        }
        return XmlElement.read(prefix + name, Files.readAllBytes(file));
    }
}
