// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import reve.pe.PhysicsException;
import reve.pe.PreparedLibrary;
import reve.pe.Prototype;
import reve.pe.PythonLaw;
import reve.pe.Status;
import reve.pe.vesper.LawText;
import reve.pe.vesper.LibraryFile;
import reve.pe.vesper.VesperConfig;

import java.io.IOException;
import java.nio.file.Path;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.ConcurrentHashMap;

/**
 * Opens the law libraries of an engine: reads their bytes, decides which libraries run in a
 * sandbox, and tests the libraries. For any thread.
 */
final class LibraryOpener {
    private final Hosts hosts;
    private final VesperConfig config;
    private final Prototype prototype;
    private final ApartRule apart;
    private final TestedLibraries tested = new TestedLibraries();

    /** The answers of the rule, by the SHA-256 of the library's bytes. */
    private final Map<String, ApartRule.Isolation> isolations = new ConcurrentHashMap<>();

    LibraryOpener(Hosts hosts, VesperConfig config, Prototype prototype, ApartRule apart) {
        this.hosts = hosts;
        this.config = config;
        this.prototype = prototype;
        this.apart = apart;
    }

    PreparedLibrary open(Path file) {
        String name = file.getFileName().toString();
        try {
            if (name.endsWith(PreparedLibrary.TEXT_ENDING)) {
                return openText(name, LawText.read(file));
            }
            byte[] bytes = LibraryFile.read(file);
            return name.endsWith(PreparedLibrary.PYTHON_ENDING)
                    ? openPython(Optional.of(file), name, bytes)
                    : openNative(Optional.of(file), file.toString(), bytes);
        } catch (IOException e) {
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED, file + " cannot be read: " + e.getMessage());
        }
    }

    PreparedLibrary open(byte[] library) {
        if (PreparedLibrary.isPython(library)) {
            return openPython(Optional.empty(), PythonLaw.nameOf(library), library);
        }
        return PreparedLibrary.isText(library)
                ? openText("text", library)
                : openNative(Optional.empty(), "a law library", library);
    }

    PreparedLibrary openText(String source, byte[] text) {
        String name = LawText.name(prototype, source, text);
        return new HostedLibrary(source, text, HostedLibrary.Form.TEXT).declared(name, "");
    }

    private PreparedLibrary openNative(Optional<Path> file, String source, byte[] bytes) {
        return open(
                source,
                bytes,
                switch (isolation(file, bytes)) {
                    case NONE -> HostedLibrary.Form.NATIVE;
                    case APART -> HostedLibrary.Form.APART;
                    case APART_WEAKLY -> HostedLibrary.Form.APART_WEAKLY;
                });
    }

    private PreparedLibrary openPython(Optional<Path> file, String source, byte[] bytes) {
        if (isolation(file, bytes) != ApartRule.Isolation.NONE) {
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED,
                    source
                            + ": a law in Python cannot run apart; write it as text or in C++, or"
                            + " move it to a folder that you trust (--laws)");
        }
        PythonLaw.requireLaw(source, bytes);
        return open(source, bytes, HostedLibrary.Form.PYTHON);
    }

    private ApartRule.Isolation isolation(Optional<Path> file, byte[] bytes) {
        return isolations.computeIfAbsent(LibraryFile.sha256(bytes), _ -> apart.of(file, bytes));
    }

    private PreparedLibrary open(String source, byte[] bytes, HostedLibrary.Form form) {
        HostedLibrary library = new HostedLibrary(source, bytes, form);
        Optional<TestedLibraries.Declared> known = tested.find(library);
        if (known.isPresent()) {
            return library.declared(known.get().name(), known.get().versions());
        }
        new Trial(hosts, config, prototype).test(library);
        tested.add(library);
        return library;
    }
}
