// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;

/**
 * Certificates of nodes, which the commands of docs/cluster.md make: an authority {@code ca} and a
 * certificate for each node.
 */
final class NodeCertificates {
    private final Path folder;

    /** Makes the authority. */
    NodeCertificates(Path folder) throws IOException {
        this.folder = folder;
        openssl("-days", "2", "-subj", "/CN=lab", "-keyout", "ca.key", "-out", "ca.crt");
    }

    /** Returns the certificate of the authority. */
    Path authority() {
        return folder.resolve("ca.crt");
    }

    /** Returns the certificate of a node at an address. Makes it if there is none. */
    Path certificate(String node, String address) throws IOException {
        Path file = folder.resolve(node + ".crt");
        if (!Files.exists(file)) {
            openssl(
                    "-days",
                    "2",
                    "-subj",
                    "/CN=" + node,
                    "-addext",
                    "subjectAltName=IP:" + address,
                    "-addext",
                    "basicConstraints=critical,CA:FALSE",
                    "-CA",
                    "ca.crt",
                    "-CAkey",
                    "ca.key",
                    "-keyout",
                    key(node).getFileName().toString(),
                    "-out",
                    file.getFileName().toString());
        }
        return file;
    }

    /** Returns the private key of a node that has a certificate. */
    Path key(String node) {
        return folder.resolve(node + ".key");
    }

    /** Returns the options of a node at an address. */
    List<String> options(String node, String address) throws IOException {
        return List.of(
                "--cluster-certificate",
                certificate(node, address).toString(),
                "--cluster-key",
                key(node).toString(),
                "--cluster-ca",
                authority().toString());
    }

    private void openssl(String... arguments) throws IOException {
        List<String> command =
                new ArrayList<>(
                        List.of(
                                "openssl",
                                "req",
                                "-x509",
                                "-nodes",
                                "-newkey",
                                "ec",
                                "-pkeyopt",
                                "ec_paramgen_curve:P-256"));
        command.addAll(List.of(arguments));
        Process process =
                new ProcessBuilder(command)
                        .directory(folder.toFile())
                        .redirectErrorStream(true)
                        .start();
        String output = new String(process.getInputStream().readAllBytes());
        assertThat(process.onExit().join().exitValue()).as(output).isZero();
    }
}
