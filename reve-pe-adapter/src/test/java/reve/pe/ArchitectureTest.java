// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import static com.tngtech.archunit.core.domain.JavaCall.Predicates.target;
import static com.tngtech.archunit.core.domain.JavaClass.Predicates.assignableTo;
import static com.tngtech.archunit.core.domain.properties.HasName.Predicates.name;
import static com.tngtech.archunit.core.domain.properties.HasOwner.Predicates.With.owner;
import static com.tngtech.archunit.lang.syntax.ArchRuleDefinition.noClasses;

import static org.assertj.core.api.Assertions.assertThat;

import com.tngtech.archunit.core.domain.JavaClasses;
import com.tngtech.archunit.core.importer.ClassFileImporter;

import org.junit.jupiter.api.Test;

import java.lang.foreign.Linker;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.SymbolLookup;

class ArchitectureTest {
    private static final String[] NATIVE_PACKAGES = {"reve.pe.vesper", "reve.pe.posix"};

    /** The classes of this project without its tests. */
    private final JavaClasses classes =
            new ClassFileImporter()
                    .importUrl(
                            PhysicsEngine.class
                                    .getProtectionDomain()
                                    .getCodeSource()
                                    .getLocation());

    @Test
    void theClassesUnderTestAreFound() {
        assertThat(classes.contain("reve.pe.PhysicsEngine")).isTrue();
        assertThat(classes.contain("reve.pe.vesper.VesperEngine")).isTrue();
        assertThat(classes.contain("reve.pe.adapter.PhysicsAdapter")).isTrue();
        assertThat(classes.contain(ArchitectureTest.class)).isFalse();
    }

    @Test
    void theEnginesAndTheirBindingsKnowNothingOfReve() {
        noClasses()
                .that()
                .resideOutsideOfPackage("reve.pe.adapter..")
                .should()
                .dependOnClassesThat()
                .resideInAnyPackage("reve.core..", "reve.worlds..", "reve.pe.adapter..")
                .check(classes);
    }

    @Test
    void whatAnEngineIsNamesNoEngine() {
        noClasses()
                .that()
                .resideInAnyPackage("reve.pe", "reve.pe.adapter")
                .should()
                .dependOnClassesThat()
                .resideInAPackage("reve.pe.vesper")
                .check(classes);
    }

    @Test
    void nativeFunctionsAreCalledInOnePackagePerLibrary() {
        noClasses()
                .that()
                .resideOutsideOfPackages(NATIVE_PACKAGES)
                .should()
                .dependOnClassesThat()
                .belongToAnyOf(Linker.class, SymbolLookup.class)
                .check(classes);
        for (String restricted : new String[] {"reinterpret", "ofAddress"}) {
            noClasses()
                    .that()
                    .resideOutsideOfPackages(NATIVE_PACKAGES)
                    .should()
                    .callMethodWhere(
                            target(name(restricted))
                                    .and(target(owner(assignableTo(MemorySegment.class)))))
                    .check(classes);
        }
    }
}
