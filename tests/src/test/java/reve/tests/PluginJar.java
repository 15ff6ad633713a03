// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.io.OutputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.jar.Attributes;
import java.util.jar.JarEntry;
import java.util.jar.JarOutputStream;
import java.util.jar.Manifest;
import java.util.regex.Matcher;
import java.util.regex.Pattern;
import java.util.stream.Stream;

import javax.tools.ToolProvider;

/** Compiles sources in Java and puts the classes into the jar of a plugin. */
final class PluginJar {
    static final String ACTION = "reve.core.access.ActionProvider";
    static final String SYMBOL = "reve.core.world.SymbolProvider";
    static final String SENSOR = "reve.core.world.SensorProvider";
    static final String LISTENER = "reve.core.frame.FrameListenerProvider";

    private static final Pattern CLASS = Pattern.compile("public final class (\\w+)");
    private static final String PACKAGE = "plug";

    private final Path classes;
    private final Map<String, String> services = new LinkedHashMap<>();
    private final Map<String, String> sources = new LinkedHashMap<>();
    private String version = "";

    /**
     * @param folder an existing folder for sources and classes
     */
    PluginJar(Path folder) throws IOException {
        classes = Files.createTempDirectory(folder, "classes");
    }

    /** Adds a class of the package {@code plug} that provides a service. */
    PluginJar with(String service, String source) {
        Matcher named = CLASS.matcher(source);
        assertThat(named.find()).as(source).isTrue();
        sources.put(named.group(1), source);
        services.merge(
                service, PACKAGE + "." + named.group(1), (first, second) -> first + "\n" + second);
        return this;
    }

    /** Adds a service whose class is not in the jar. */
    PluginJar withoutClass(String service, String name) {
        services.put(service, name);
        return this;
    }

    PluginJar version(String text) {
        version = text;
        return this;
    }

    private void compile() throws IOException {
        List<String> arguments =
                new ArrayList<>(
                        List.of(
                                "-proc:none",
                                "-d",
                                classes.toString(),
                                "-cp",
                                System.getProperty("java.class.path")));
        for (Map.Entry<String, String> source : sources.entrySet()) {
            Path file = classes.resolve(source.getKey() + ".java");
            Files.writeString(file, "package " + PACKAGE + ";\n" + source.getValue());
            arguments.add(file.toString());
        }
        if (sources.isEmpty()) {
            return;
        }
        var errors = new ByteArrayOutputStream();
        int status =
                ToolProvider.getSystemJavaCompiler()
                        .run(null, null, errors, arguments.toArray(String[]::new));
        assertThat(status).as(errors.toString(StandardCharsets.UTF_8)).isZero();
    }

    /** Writes the jar. */
    Path write(Path jar) throws IOException {
        return write(jar, 0);
    }

    /**
     * Writes the jar.
     *
     * @param classVersion version of the class files; 0 for that of this Java
     */
    Path write(Path jar, int classVersion) throws IOException {
        compile();
        Files.createDirectories(jar.getParent());
        var manifest = new Manifest();
        manifest.getMainAttributes().put(Attributes.Name.MANIFEST_VERSION, "1.0");
        if (!version.isEmpty()) {
            manifest.getMainAttributes().put(Attributes.Name.IMPLEMENTATION_VERSION, version);
        }
        try (OutputStream out = Files.newOutputStream(jar);
                JarOutputStream files = new JarOutputStream(out, manifest);
                Stream<Path> compiled = Files.walk(classes)) {
            for (Path file : compiled.filter(each -> each.toString().endsWith(".class")).toList()) {
                byte[] bytes = Files.readAllBytes(file);
                if (classVersion > 0) {
                    bytes[6] = (byte) (classVersion >> 8);
                    bytes[7] = (byte) classVersion;
                }
                put(files, classes.relativize(file).toString(), bytes);
            }
            for (Map.Entry<String, String> service : services.entrySet()) {
                put(
                        files,
                        "META-INF/services/" + service.getKey(),
                        (service.getValue() + "\n").getBytes(StandardCharsets.UTF_8));
            }
        }
        return jar;
    }

    private static void put(JarOutputStream files, String name, byte[] bytes) throws IOException {
        files.putNextEntry(new JarEntry(name));
        files.write(bytes);
        files.closeEntry();
    }
}
