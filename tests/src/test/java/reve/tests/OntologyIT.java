// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.apache.jena.rdf.model.InfModel;
import org.apache.jena.rdf.model.Model;
import org.apache.jena.rdf.model.ModelFactory;
import org.apache.jena.rdf.model.Property;
import org.apache.jena.rdf.model.RDFNode;
import org.apache.jena.rdf.model.Resource;
import org.apache.jena.rdf.model.Statement;
import org.apache.jena.reasoner.ReasonerRegistry;
import org.apache.jena.riot.Lang;
import org.apache.jena.riot.RDFDataMgr;
import org.apache.jena.vocabulary.OWL;
import org.apache.jena.vocabulary.RDF;
import org.apache.jena.vocabulary.RDFS;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.world.Column;
import reve.core.world.Item;
import reve.core.world.ScalarType;
import reve.core.world.Table;
import reve.tests.Reve.Outcome;
import reve.worlds.server.Simulation;

import java.io.InputStream;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.TreeSet;
import java.util.stream.Collectors;

/**
 * Ontologies that {@code export} writes. Apache Jena, which shares no code with the project, reads
 * them, and its OWL reasoner answers questions about them.
 */
class OntologyIT {
    private static final String WORLD =
            """
            reve: 1
            name: tea room
            doc: A room, with tea.
            laws: [newton_motion]
            properties:
              - {name: temperature, kind: body, unit: K}
              - {name: speed, kind: body, components: 2, unit: km/h}
            classes:
              container: {doc: Holds other things.}
              vessel: {is: container, semantic: {holds: liquid, fragile: false}}
              cup: {is: vessel, semantic: {fragile: true}, physics: {mass: 80 g}}
              basket: container
            symbols: {depth: {type: number, unit: mm, doc: Inside.}}
            rules: {hot: physics.temperature > 350}
            items:
              - {name: table, physical: {shape: box, size: [1, 1, 1], location: [0, -0.5, 0]}}
              - name: my cup
                physical: {shape: box, size: [0.1, 0.1, 0.1], location: [0, 0.05, 0]}
                semantic: {class: cup, tags: [red, 2, true], depth: 80}
                physics: {temperature: 360, speed: [36, 0], velocity: [0.1, 0, 0]}
                access: {drink: {effects: [{raise: sip}]}}
              - {name: spoon, parent: my cup, physical: {shape: box, size: [0.01, 0.2, 0.01]}}
              - {name: Krug «ü», physical: {location: [5, 0, 0]}, semantic: {class: vessel}}
              - {name: hamper, semantic: {class: basket}}
              - {name: stone, semantic: {class: dark matter}}
              - {name: rubber, kind: spring, physics: {springConstant: 5, end1: my cup, end2: anchor}}
              - {name: anchor, physics: {mass: 0}}
            """;

    private static final String XSD = "http://www.w3.org/2001/XMLSchema#";
    private static final String OWN = "urn:reve:world:tea%20room:";

    @TempDir private Path folder;

    private Path world() throws Exception {
        return Files.writeString(folder.resolve("world.yaml"), WORLD);
    }

    private Path export(Path world, String... options) throws Exception {
        Path out = folder.resolve("out" + options.length + ".jsonld");
        List<String> command =
                new ArrayList<>(List.of("export", world.toString(), "--json-ld", out.toString()));
        command.addAll(List.of(options));
        Outcome outcome = Reve.run(command.toArray(String[]::new));
        assertThat(outcome.code()).as(outcome.err()).isZero();
        return out;
    }

    private static Model read(Path file) throws Exception {
        Model model = ModelFactory.createDefaultModel();
        try (InputStream in = Files.newInputStream(file)) {
            RDFDataMgr.read(model, in, Lang.JSONLD);
        }
        return model;
    }

    /** Returns the labels of the individuals that belong to a class, according to the reasoner. */
    private static Set<String> labels(Model model, String type) {
        return model
                .listSubjectsWithProperty(RDF.type, model.createResource(type))
                .toList()
                .stream()
                .map(each -> each.getProperty(RDFS.label).getString())
                .collect(Collectors.toCollection(TreeSet::new));
    }

    private static Set<String> values(Model model, String item, String property) {
        return model
                .listObjectsOfProperty(model.createResource(item), model.createProperty(property))
                .toList()
                .stream()
                .map(OntologyIT::text)
                .collect(Collectors.toCollection(TreeSet::new));
    }

    /** Returns an IRI, a text, or a value with the IRI of its type. */
    private static String text(RDFNode node) {
        if (!node.isLiteral()) {
            return node.toString();
        }
        String type = node.asLiteral().getDatatypeURI();
        String text = node.asLiteral().getLexicalForm();
        return type.equals(XSD + "string") ? text : text + "^^" + type;
    }

    @Test
    void aReasonerFindsTheItemsOfAllClassesBelow() throws Exception {
        Model told = read(export(world(), "--relations"));
        assertThat(labels(told, OWN + "class:vessel")).containsExactly("Krug «ü»");

        InfModel all = ModelFactory.createInfModel(ReasonerRegistry.getOWLReasoner(), told);
        assertThat(all.validate().isValid()).isTrue();
        assertThat(labels(all, OWN + "class:vessel")).containsExactly("Krug «ü»", "my cup");
        assertThat(labels(all, OWN + "class:container"))
                .containsExactly("Krug «ü»", "hamper", "my cup");
        assertThat(labels(all, "urn:reve:kind:body"))
                .containsExactly(
                        "Krug «ü»", "anchor", "hamper", "my cup", "spoon", "stone", "table");
        assertThat(labels(all, OWN + "class:dark%20matter")).containsExactly("stone");
        assertThat(labels(all, "urn:reve:kind:spring")).containsExactly("rubber");
        // touching is symmetric, so both directions hold
        String cup = OWN + "item:my%20cup";
        assertThat(values(told, cup, "urn:reve:term:on")).containsExactly(OWN + "item:table");
        assertThat(values(all, OWN + "item:table", "urn:reve:term:touching")).contains(cup);
    }

    @Test
    void anItemWithAPropertyIsAnItemOfItsKind() throws Exception {
        Model told = read(export(world()));
        Resource more = told.createResource("urn:other:thing");
        more.addLiteral(told.createProperty("urn:reve:property:mass"), 3.0);
        InfModel all = ModelFactory.createInfModel(ReasonerRegistry.getOWLReasoner(), told);
        assertThat(all.contains(more, RDF.type, told.createResource("urn:reve:kind:body")))
                .isTrue();
        assertThat(
                        told.listStatements(
                                null, told.createProperty("urn:reve:term:on"), (RDFNode) null))
                .isExhausted();
    }

    @Test
    void symbolsReferencesAndUnitsAreExported() throws Exception {
        Model model = read(export(world()));
        String cup = OWN + "item:my%20cup";
        String xsd = "^^" + XSD;
        assertThat(values(model, cup, OWN + "symbol:holds")).containsExactly("liquid");
        assertThat(values(model, cup, OWN + "symbol:fragile"))
                .containsExactly("true" + xsd + "boolean");
        assertThat(values(model, cup, OWN + "symbol:hot"))
                .containsExactly("true" + xsd + "boolean");
        assertThat(values(model, cup, OWN + "symbol:tags"))
                .containsExactly("2.0" + xsd + "double", "red", "true" + xsd + "boolean");
        assertThat(values(model, cup, OWN + "symbol:depth"))
                .as("80 mm in SI units")
                .containsExactly("0.08" + xsd + "double");
        assertThat(values(model, cup, OWN + "property:speed.0"))
                .as("36 km/h in SI units")
                .containsExactly("10.0" + xsd + "double");
        assertThat(values(model, cup, "urn:reve:property:mass"))
                .as("from its class")
                .containsExactly("0.08" + xsd + "double");
        assertThat(values(model, cup, "urn:reve:term:action")).containsExactly("drink");
        assertThat(values(model, cup, "urn:reve:property:shape")).containsExactly("box");
        assertThat(values(model, OWN + "item:spoon", "urn:reve:term:parent")).containsExactly(cup);
        assertThat(values(model, OWN + "item:rubber", "urn:reve:property:end1"))
                .containsExactly(cup);
        assertThat(values(model, OWN + "class:container", RDFS.comment.getURI()))
                .containsExactly("Holds other things.");
        assertThat(values(model, "urn:reve:world:tea%20room", RDFS.comment.getURI()))
                .containsExactly("A room, with tea.");

        String unit =
                values(model, "urn:reve:property:velocity.x", "http://qudt.org/schema/qudt/hasUnit")
                        .iterator()
                        .next();
        assertThat(values(model, unit, "http://qudt.org/schema/qudt/ucumCode"))
                .containsExactly("m.s-1");
        assertThat(values(model, unit, "http://qudt.org/schema/qudt/hasDimensionVector"))
                .containsExactly("http://qudt.org/vocab/dimensionvector/A0E0L1I0M0H0T-1D0");
        String none =
                values(
                                model,
                                "urn:reve:property:orientation.w",
                                "http://qudt.org/schema/qudt/hasUnit")
                        .iterator()
                        .next();
        assertThat(values(model, none, "http://qudt.org/schema/qudt/hasDimensionVector"))
                .containsExactly("http://qudt.org/vocab/dimensionvector/A0E0L0I0M0H0T0D1");
    }

    /** Each property and class that an individual uses is declared, as OWL requires. */
    @Test
    void everyTermIsDeclared() throws Exception {
        Model model = read(export(world(), "--relations"));
        for (Resource item : model.listSubjectsWithProperty(RDF.type, individual(model)).toList()) {
            for (Statement statement : item.listProperties().toList()) {
                Property property = statement.getPredicate();
                if (property.equals(RDF.type)) {
                    Resource type = statement.getResource();
                    assertThat(
                                    type.equals(individual(model))
                                            || model.contains(type, RDF.type, OWL.Class))
                            .as("%s of %s", type, item)
                            .isTrue();
                } else if (!property.equals(RDFS.label)) {
                    boolean isLiteral = statement.getObject().isLiteral();
                    assertThat(
                                    model.contains(
                                            property,
                                            RDF.type,
                                            isLiteral ? OWL.DatatypeProperty : OWL.ObjectProperty))
                            .as("%s of %s", property, item)
                            .isTrue();
                }
            }
        }
        assertThat(model.listSubjectsWithProperty(RDF.type, individual(model)).toList()).hasSize(9);
    }

    private static Resource individual(Model model) {
        return model.createResource("http://www.w3.org/2002/07/owl#NamedIndividual");
    }

    /** All numbers of a sample world with all their bits, after half a second of its laws. */
    @Test
    void theNumbersHaveTheBitsOfTheWorld() throws Exception {
        Path orbit = Project.WORLDS.resolve("spring-orbit");
        Model model = read(export(orbit, "--at", "0.5"));
        int compared = 0;
        try (Simulation simulation =
                new Simulation(WorldFile.load(orbit.resolve("world.yaml")), Pacing.FAST)) {
            simulation.loop().run(30);
            Table bodies = simulation.world().table("body");
            for (int row = 0; row < bodies.physicsRowCount(); row++) {
                Item item = simulation.world().item(bodies.idAt(row));
                Resource individual =
                        model.listSubjectsWithProperty(RDFS.label, item.name()).next();
                for (Column column : bodies.columns()) {
                    if (column.type() != ScalarType.F64
                            || column.components() != 3
                            || column.name().startsWith("bounds")) {
                        continue;
                    }
                    for (Map.Entry<String, Integer> axis :
                            Map.of("x", 0, "y", 1, "z", 2).entrySet()) {
                        double written =
                                individual
                                        .getProperty(
                                                model.createProperty(
                                                        "urn:reve:property:"
                                                                + column.name()
                                                                + "."
                                                                + axis.getKey()))
                                        .getDouble();
                        assertThat(Double.doubleToRawLongBits(written))
                                .as("%s of %s", column.name(), item)
                                .isEqualTo(
                                        Double.doubleToRawLongBits(
                                                column.getDouble(row, axis.getValue())));
                        compared++;
                    }
                }
            }
        }
        assertThat(compared).isGreaterThan(30);
    }

    @Test
    void equalStatesGiveEqualBytes() throws Exception {
        Path world = world();
        Path out = export(world, "--relations", "--at", "0.25");
        byte[] bytes = Files.readAllBytes(out);
        Model live = read(out);
        assertThat(export(world, "--relations", "--at", "0.25")).hasBinaryContent(bytes);

        Path log = folder.resolve("run.log");
        Outcome run =
                Reve.run("run", world.toString(), "--seconds", "0.5", "--record", log.toString());
        assertThat(run.code()).as(run.err()).isZero();
        Model recorded = read(export(log, "--relations", "--at", "0.25"));
        String cup = OWN + "item:my%20cup";
        for (String axis : List.of("x", "y", "z")) {
            String place = "urn:reve:property:position." + axis;
            assertThat(values(recorded, cup, place)).isEqualTo(values(live, cup, place));
        }
        assertThat(labels(recorded, OWN + "class:cup")).containsExactly("my cup");
    }

    @Test
    void wrongOptionsAreRefused() throws Exception {
        Path world = world();
        assertThat(Reve.run("export", world.toString(), "--json-ld", "a", "--csv", "b").err())
                .contains("--csv and --mcap write the frames of a recording or a store");
        assertThat(Reve.run("export", world.toString(), "--csv", "b", "--relations").err())
                .contains("--at and --relations are for --json-ld FILE, which is missing");
        Path notes = Files.writeString(folder.resolve("notes.txt"), "precious");
        assertThat(Reve.run("export", world.toString(), "--json-ld", notes.toString()).err())
                .contains("exists and is not a JSON-LD file");
        assertThat(Files.readString(notes)).isEqualTo("precious");
        assertThat(
                        Reve.run(
                                        "export",
                                        folder.resolve("none").toString(),
                                        "--json-ld",
                                        folder.resolve("x").toString())
                                .code())
                .isNotZero();
    }
}
