// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static com.tngtech.archunit.lang.syntax.ArchRuleDefinition.noClasses;
import static com.tngtech.archunit.library.dependencies.SlicesRuleDefinition.slices;

import static org.assertj.core.api.Assertions.assertThat;

import com.tngtech.archunit.base.DescribedPredicate;
import com.tngtech.archunit.core.domain.JavaClasses;
import com.tngtech.archunit.core.domain.JavaMethodCall;
import com.tngtech.archunit.core.importer.ClassFileImporter;
import com.tngtech.archunit.core.importer.ImportOption;

import org.junit.jupiter.api.Test;

import java.io.IOException;
import java.nio.file.Files;
import java.util.HashMap;
import java.util.Map;
import java.util.Set;
import java.util.regex.Pattern;

/** Checks the dependencies of ARCHITECTURE.md in class files and jars. */
class DependencyRulesTest {
    /** All classes of the project except tests. */
    static final JavaClasses CLASSES =
            new ClassFileImporter()
                    .withImportOption(new ImportOption.DoNotIncludeTests())
                    .importPackages("reve");

    @Test
    void coreKnowsNoEngineAndNoApplication() {
        noClasses()
                .that()
                .resideInAPackage("reve.core..")
                .should()
                .dependOnClassesThat()
                .resideInAnyPackage("reve.pe..", "reve.worlds..", "reve.agent..")
                .check(CLASSES);
    }

    @Test
    void coreCallsNoNativeCode() {
        noClasses()
                .that()
                .resideInAPackage("reve.core..")
                .should()
                .dependOnClassesThat()
                .haveFullyQualifiedName("java.lang.foreign.Linker")
                .orShould()
                .dependOnClassesThat()
                .haveFullyQualifiedName("java.lang.foreign.SymbolLookup")
                .check(CLASSES);
    }

    @Test
    void onlyTheNativePackagesOfTheAdapterCallNativeCode() {
        noClasses()
                .that()
                .resideOutsideOfPackages("reve.pe.vesper..", "reve.pe.posix..")
                .should()
                .dependOnClassesThat()
                .haveFullyQualifiedName("java.lang.foreign.Linker")
                .orShould()
                .dependOnClassesThat()
                .haveFullyQualifiedName("java.lang.foreign.SymbolLookup")
                .check(CLASSES);
    }

    /** Memory at a raw address could belong to another object, or to none. */
    @Test
    void onlyTheNativePackagesOfTheAdapterUseRawAddresses() {
        var raw =
                DescribedPredicate.<JavaMethodCall>describe(
                        "make memory of a raw address",
                        call ->
                                call.getTargetOwner()
                                                .getName()
                                                .equals("java.lang.foreign.MemorySegment")
                                        && Set.of("ofAddress", "reinterpret")
                                                .contains(call.getName()));
        noClasses()
                .that()
                .resideOutsideOfPackages("reve.pe.vesper..", "reve.pe.posix..")
                .should()
                .callMethodWhere(raw)
                .check(CLASSES);
        assertThat(CLASSES.get("reve.pe.posix.SharedMemory").getMethodCallsFromSelf())
                .as("calls that the rule finds")
                .anyMatch(raw);
    }

    @Test
    void theEngineBindingKnowsNothingOfReve() {
        noClasses()
                .that()
                .resideInAnyPackage("reve.pe", "reve.pe.vesper..", "reve.pe.posix..")
                .should()
                .dependOnClassesThat()
                .resideInAnyPackage("reve.core..", "reve.pe.adapter..", "reve.worlds..")
                .check(CLASSES);
    }

    @Test
    void theAdapterKnowsNoApplicationAndNoParticularEngine() {
        noClasses()
                .that()
                .resideInAPackage("reve.pe.adapter..")
                .should()
                .dependOnClassesThat()
                .resideInAnyPackage("reve.worlds..", "reve.pe.vesper..")
                .check(CLASSES);
    }

    @Test
    void clientsKnowTheProtocolOnly() {
        noClasses()
                .that()
                .resideInAPackage("reve.agent..")
                .should()
                .dependOnClassesThat()
                .resideInAnyPackage("reve.core..", "reve.pe..", "reve.worlds..")
                .check(CLASSES);
    }

    @Test
    void theRoomsOfTheAgentServerFormNoCycles() {
        slices().matching("reve.core.agent.(*)..").should().beFreeOfCycles().check(CLASSES);
        noClasses()
                .that()
                .resideInAPackage("reve.core.agent.*..")
                .should()
                .dependOnClassesThat()
                .resideInAPackage("reve.core.agent")
                .check(CLASSES);
    }

    @Test
    void messagesAndPerceptionsKnowNoSocket() {
        noClasses()
                .that()
                .resideInAnyPackage(
                        "reve.core.agent.protocol..",
                        "reve.core.agent.perception..",
                        "reve.core.agent.embodiment..",
                        "reve.core.agent.lockstep..")
                .should()
                .dependOnClassesThat()
                .resideInAPackage("java.nio.channels..")
                .check(CLASSES);
    }

    @Test
    void onlyTheAgentServerUsesItsInnerRooms() {
        noClasses()
                .that()
                .resideOutsideOfPackage("reve.core.agent..")
                .should()
                .dependOnClassesThat()
                .resideInAnyPackage(
                        "reve.core.agent.perception..",
                        "reve.core.agent.embodiment..",
                        "reve.core.agent.lockstep..",
                        "reve.core.agent.net..",
                        "reve.core.agent.publish..",
                        "reve.core.agent.control..",
                        "reve.core.agent.session..")
                .check(CLASSES);
    }

    @Test
    void worldsKnowNoPageAndThePageKnowsNoCommandLine() {
        noClasses()
                .that()
                .resideInAnyPackage("reve.worlds", "reve.worlds.server..", "reve.worlds.journal..")
                .should()
                .dependOnClassesThat()
                .resideInAnyPackage("reve.worlds.web..", "reve.worlds.cli..")
                .check(CLASSES);
        noClasses()
                .that()
                .resideInAPackage("reve.worlds.web..")
                .should()
                .dependOnClassesThat()
                .resideInAnyPackage("reve.worlds.cli..", "reve.pe..")
                .check(CLASSES);
    }

    /** A server without a cluster loads none of its classes. */
    @Test
    void onlyTheClusterUsesPekkoAndOnlyTheCommandLineUsesTheCluster() {
        noClasses()
                .that()
                .resideOutsideOfPackage("reve.worlds.cluster..")
                .should()
                .dependOnClassesThat()
                .resideInAnyPackage("org.apache.pekko..", "scala..", "com.typesafe..")
                .check(CLASSES);
        noClasses()
                .that()
                .resideOutsideOfPackages("reve.worlds.cluster..", "reve.worlds.cli..")
                .should()
                .dependOnClassesThat()
                .resideInAPackage("reve.worlds.cluster..")
                .check(CLASSES);
    }

    @Test
    void theWorldStoreAndTheAdapterBringNoReaderOfAFormat() throws IOException {
        Pattern readers =
                Pattern.compile("(jackson|snakeyaml|msgpack|json-schema|jgltf|cel|icu4j)-.*");
        for (String name : new String[] {"reve-core-world", "reve-pe-adapter"}) {
            assertThat(Jars.broughtBy(name))
                    .as(name)
                    .anyMatch(jar -> jar.startsWith("pcollections"))
                    .noneMatch(readers.asMatchPredicate());
        }
        assertThat(Jars.broughtBy("reve-core-files"))
                .anyMatch(readers.asMatchPredicate())
                .noneMatch(jar -> jar.startsWith("msgpack"));
    }

    @Test
    void noPackageIsInTwoProjects() throws IOException {
        Map<String, String> owners = new HashMap<>();
        for (String name : Jars.NAMES) {
            for (String packaged : Jars.packages(name)) {
                String other = owners.put(packaged, name);
                assertThat(other).as("%s is in %s too", packaged, name).isNull();
            }
        }
        assertThat(owners).containsEntry("reve/core/world", "reve-core-world");
    }

    @Test
    void eachJarNamesFilesBesideItAndIsDescribed() throws IOException {
        String page = Files.readString(Project.ROOT.resolve("docs/java.md"));
        for (String name : Jars.NAMES) {
            assertThat(page).contains("| `" + name + ".jar` |");
            assertThat(Jars.broughtBy(name))
                    .allSatisfy(jar -> assertThat(Jars.FOLDER.resolve(jar)).exists());
        }
    }

    @Test
    void packagesFormNoCycles() {
        slices().matching("reve.(*).(*)..").should().beFreeOfCycles().check(CLASSES);
    }
}
