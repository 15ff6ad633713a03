// SPDX-License-Identifier: Apache-2.0
package reve.worlds.export;

import reve.core.unit.SiBase;
import reve.core.unit.Unit;
import reve.core.world.ClassHierarchy;
import reve.core.world.ColumnView;
import reve.core.world.ItemClass;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.PropertyDescriptor;
import reve.core.world.Relations;
import reve.core.world.ScalarType;
import reve.core.world.StandardSymbols;
import reve.core.world.SymbolDescriptor;
import reve.core.world.SymbolType;
import reve.core.world.TableSnapshot;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.io.OutputStream;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.TreeMap;
import java.util.TreeSet;
import java.util.stream.Collectors;
import java.util.stream.Stream;

/**
 * One state of a world as an OWL ontology in JSON-LD 1.1. Kinds and classes of items are OWL
 * classes, and items are individuals. Each component of a property is a datatype property. Numbers
 * are in SI units. Equal states give equal bytes. For one thread.
 */
public final class OntologyExport {
    /** Text that the beginning of each file contains. */
    public static final String MARK = "\"@context\"";

    private static final String VOCABULARY = "urn:reve:";

    /** The relations between bodies that hold in both directions. */
    private static final Set<String> SYMMETRIC = Set.of("near", "touching");

    /** Symbols that are types, labels or properties of the individual. */
    private static final Set<String> OMITTED =
            Set.of("name", "class", "dimensions", StandardSymbols.CLASSES);

    /** Kinds whose meaning is the same in all worlds. */
    private static final Set<String> STANDARD_KINDS =
            Set.of(
                    WorldPrototype.BODY,
                    WorldPrototype.SPRING,
                    WorldPrototype.SURFACE,
                    WorldPrototype.WORLD,
                    WorldPrototype.JOINT,
                    WorldPrototype.GEAR,
                    WorldPrototype.SUBSTANCE_PAIR);

    /** Order of base units in QUDT dimension vectors, and the letter of each. */
    private static final Map<SiBase, String> DIMENSIONS = dimensions();

    private final JsonMapper json = new JsonMapper();
    private final OutputStream out;
    private final WorldPrototype prototype;
    private final WorldSnapshot snapshot;
    private final Set<String> standardProperties;
    private final Map<String, Map<String, Object>> units = new TreeMap<>();
    private boolean begun;

    private OntologyExport(OutputStream out, WorldPrototype prototype, WorldSnapshot snapshot) {
        this.out = out;
        this.prototype = prototype;
        this.snapshot = snapshot;
        this.standardProperties = standardProperties(prototype);
    }

    private static Map<SiBase, String> dimensions() {
        Map<SiBase, String> letters = new LinkedHashMap<>();
        letters.put(SiBase.MOLE, "A");
        letters.put(SiBase.AMPERE, "E");
        letters.put(SiBase.METRE, "L");
        letters.put(SiBase.CANDELA, "I");
        letters.put(SiBase.KILOGRAM, "M");
        letters.put(SiBase.KELVIN, "H");
        letters.put(SiBase.SECOND, "T");
        return letters;
    }

    /**
     * Writes a state as UTF-8. Leaves the stream open.
     *
     * @param world name of the world
     * @param doc description of the world; may be empty
     * @param relations whether to write the spatial relations of bodies, which are computed for
     *     this purpose
     */
    public static void write(
            OutputStream out,
            String world,
            String doc,
            WorldPrototype prototype,
            WorldSnapshot snapshot,
            boolean relations)
            throws IOException {
        new OntologyExport(out, prototype, snapshot).write(world, doc, relations);
    }

    private void write(String world, String doc, boolean relations) throws IOException {
        text("{\"@context\":" + json.writeValueAsString(context(world)) + ",\n\"@graph\":[");
        node(header(world, doc));
        writeVocabulary(relations);
        writeClasses();
        writeProperties();
        writeSymbols();
        Optional<Relations> related =
                relations ? Optional.of(snapshot.relations()) : Optional.empty();
        for (TableSnapshot table : snapshot.tables()) {
            writeItems(table, related);
        }
        for (Map<String, Object> unit : units.values()) {
            node(unit);
        }
        text("\n]}\n");
    }

    private void text(String text) throws IOException {
        out.write(text.getBytes(StandardCharsets.UTF_8));
    }

    private void node(Map<String, Object> node) throws IOException {
        text((begun ? ",\n" : "\n") + json.writeValueAsString(node));
        begun = true;
    }

    private Map<String, Object> context(String world) {
        String own = VOCABULARY + "world:" + encoded(world) + ":";
        Map<String, Object> context = new LinkedHashMap<>();
        context.put("rdfs", "http://www.w3.org/2000/01/rdf-schema#");
        context.put("owl", "http://www.w3.org/2002/07/owl#");
        context.put("xsd", "http://www.w3.org/2001/XMLSchema#");
        context.put("qudt", "http://qudt.org/schema/qudt/");
        context.put("dimension", "http://qudt.org/vocab/dimensionvector/");
        context.put("reve", VOCABULARY + "term:");
        context.put("unit", VOCABULARY + "unit:");
        context.put("kind", VOCABULARY + "kind:");
        context.put("property", VOCABULARY + "property:");
        context.put("ownKind", own + "kind:");
        context.put("ownProperty", own + "property:");
        context.put("class", own + "class:");
        context.put("symbol", own + "symbol:");
        context.put("item", own + "item:");
        context.put("rdfs:subClassOf", Map.of("@type", "@id"));
        context.put("rdfs:domain", Map.of("@type", "@id"));
        context.put("rdfs:range", Map.of("@type", "@id"));
        context.put("qudt:hasUnit", Map.of("@type", "@id"));
        context.put("qudt:hasDimensionVector", Map.of("@type", "@id"));
        for (String relation : new TreeSet<>(Relations.NAMES)) {
            context.put("reve:" + relation, Map.of("@type", "@id"));
        }
        context.put("reve:parent", Map.of("@type", "@id"));
        context.put("reve:frame", Map.of("@type", "xsd:integer"));
        context.put("reve:time", Map.of("@type", "xsd:double"));
        for (PropertyDescriptor property : properties()) {
            for (String component : Properties.components(property)) {
                if (!Properties.isText(property) || property.type() == ScalarType.REF) {
                    context.put(iri(property, component), Map.of("@type", type(property)));
                }
            }
        }
        return context;
    }

    private static Map<String, Object> typed(String id, Object type) {
        Map<String, Object> node = new LinkedHashMap<>();
        node.put("@id", id);
        node.put("@type", type);
        return node;
    }

    private Map<String, Object> header(String world, String doc) {
        Map<String, Object> node =
                typed(
                        VOCABULARY + "world:" + encoded(world),
                        List.of("owl:Ontology", "reve:World"));
        node.put("rdfs:label", world);
        if (!doc.isEmpty()) {
            node.put("rdfs:comment", doc);
        }
        node.put("reve:frame", Long.toString(snapshot.frame()));
        node.put("reve:time", Double.toString(snapshot.timeSeconds()));
        return node;
    }

    private void writeVocabulary(boolean relations) throws IOException {
        for (String each :
                List.of(
                        "qudt:hasUnit",
                        "qudt:hasDimensionVector",
                        "qudt:ucumCode",
                        "reve:frame",
                        "reve:time")) {
            node(typed(each, "owl:AnnotationProperty"));
        }
        node(typed("reve:World", "owl:Class"));
        node(described("reve:Item", "owl:Class", "item", "An item of a virtual world."));
        Map<String, Object> parent =
                described(
                        "reve:parent",
                        "owl:ObjectProperty",
                        "parent",
                        "The body with which the item moves.");
        parent.put("rdfs:range", kind(WorldPrototype.BODY));
        node(parent);
        node(
                described(
                        "reve:action",
                        "owl:DatatypeProperty",
                        "action",
                        "Name of an action that agents can perform on the item."));
        node(
                described(
                        "reve:capability",
                        "owl:DatatypeProperty",
                        "capability",
                        "Capability of an agent whose body the item is."));
        for (String relation : relations ? new TreeSet<>(Relations.NAMES) : Set.<String>of()) {
            Map<String, Object> node =
                    typed(
                            "reve:" + relation,
                            SYMMETRIC.contains(relation)
                                    ? List.of("owl:ObjectProperty", "owl:SymmetricProperty")
                                    : "owl:ObjectProperty");
            node.put("rdfs:label", relation);
            node.put("rdfs:domain", kind(WorldPrototype.BODY));
            node.put("rdfs:range", kind(WorldPrototype.BODY));
            node(node);
        }
    }

    private static Map<String, Object> described(
            String id, String type, String label, String comment) {
        Map<String, Object> node = typed(id, type);
        node.put("rdfs:label", label);
        if (!comment.isEmpty()) {
            node.put("rdfs:comment", comment);
        }
        return node;
    }

    private void writeClasses() throws IOException {
        for (String kind : prototype.kinds()) {
            Map<String, Object> node = described(kind(kind), "owl:Class", kind, "");
            node.put("rdfs:subClassOf", "reve:Item");
            node(node);
        }
        ClassHierarchy classes = prototype.classes();
        for (ItemClass each : classes.all()) {
            Map<String, Object> node =
                    described(itemClass(each.name()), "owl:Class", each.name(), each.doc());
            node.put(
                    "rdfs:subClassOf",
                    classes.find(each.parent()).isPresent()
                            ? itemClass(each.parent())
                            : kind(each.parent()));
            node(node);
        }
        Set<String> others = new TreeSet<>();
        for (ItemSymbols item : snapshot.symbols().values()) {
            if (!prototype.hasKind(item.itemClass()) && classes.find(item.itemClass()).isEmpty()) {
                others.add(item.itemClass());
            }
        }
        for (String other : others) {
            Map<String, Object> node = described(itemClass(other), "owl:Class", other, "");
            node.put("rdfs:subClassOf", "reve:Item");
            node(node);
        }
    }

    /** Returns all properties of items, except the boxes around bodies. */
    private List<PropertyDescriptor> properties() {
        List<PropertyDescriptor> all = new ArrayList<>(physical());
        all.addAll(prototype.properties());
        return all;
    }

    private List<PropertyDescriptor> physical() {
        return prototype.physicalProperties().stream()
                .filter(property -> !property.name().startsWith("bounds"))
                .toList();
    }

    private void writeProperties() throws IOException {
        for (PropertyDescriptor property : properties()) {
            boolean isReference = property.type() == ScalarType.REF;
            for (String component : Properties.components(property)) {
                Map<String, Object> node =
                        described(
                                iri(property, component),
                                isReference ? "owl:ObjectProperty" : "owl:DatatypeProperty",
                                label(property, component),
                                property.doc());
                node.put("rdfs:domain", kind(property.kind()));
                node.put(
                        "rdfs:range",
                        isReference ? kind(property.refersTo().orElseThrow()) : range(property));
                if (!Properties.isText(property)) {
                    node.put("qudt:hasUnit", unit(property.unit()));
                }
                node(node);
            }
        }
    }

    private static String range(PropertyDescriptor property) {
        return Properties.isText(property) ? "xsd:string" : type(property);
    }

    private void writeSymbols() throws IOException {
        Set<String> names = new TreeSet<>();
        for (ItemSymbols item : snapshot.symbols().values()) {
            names.addAll(item.symbols().keySet());
        }
        prototype.symbols().forEach(declared -> names.add(declared.name()));
        prototype.classes().all().forEach(each -> names.addAll(each.symbols().keySet()));
        names.removeAll(OMITTED);
        for (String name : names) {
            Map<String, Object> node =
                    described(
                            symbol(name),
                            "owl:DatatypeProperty",
                            name,
                            prototype.symbol(name).map(SymbolDescriptor::doc).orElse(""));
            node.put("rdfs:domain", "reve:Item");
            prototype
                    .symbol(name)
                    .ifPresent(
                            declared -> {
                                switch (declared.type()) {
                                    case TEXT -> node.put("rdfs:range", "xsd:string");
                                    case TRUTH -> node.put("rdfs:range", "xsd:boolean");
                                    case NUMBER -> {
                                        node.put("rdfs:range", "xsd:double");
                                        node.put("qudt:hasUnit", unit(declared.unit()));
                                    }
                                    case LIST -> {} // its elements may have different types
                                }
                            });
            node(node);
        }
    }

    private void writeItems(TableSnapshot table, Optional<Relations> relations) throws IOException {
        boolean isBody = table.kind().equals(WorldPrototype.BODY);
        for (int row = 0; row < table.rowCount(); row++) {
            int at = row;
            ItemId id = table.idAt(row);
            ItemSymbols item = snapshot.symbols().get(id);
            Map<String, Object> node = typed(item(item.name()), types(item));
            node.put("rdfs:label", item.name());
            putSymbols(node, item);
            if (item.attachment() != null) {
                ItemSymbols parent = snapshot.symbols().get(item.attachment().parent());
                node.put("reve:parent", item(parent.name()));
            }
            putNames(node, "reve:action", item.actions().stream().map(each -> each.name()));
            putNames(node, "reve:capability", item.capabilities().stream());
            if (isBody) {
                physical().forEach(property -> put(node, table, property, at));
            }
            if (row < table.physicsRowCount()) {
                for (PropertyDescriptor property : prototype.properties()) {
                    if (property.kind().equals(table.kind())) {
                        put(node, table, property, row);
                    }
                }
            }
            if (isBody) {
                relations.ifPresent(all -> putRelations(node, id, all));
            }
            node(node);
        }
    }

    /** Returns the class of an item and, if the class does not determine it, the kind. */
    private List<String> types(ItemSymbols item) {
        Set<String> types = new LinkedHashSet<>();
        types.add("owl:NamedIndividual");
        if (!prototype.hasKind(item.itemClass())) {
            types.add(itemClass(item.itemClass()));
        }
        if (!item.isA(item.kind())) {
            types.add(kind(item.kind()));
        } else if (prototype.hasKind(item.itemClass())) {
            types.add(kind(item.itemClass()));
        }
        return List.copyOf(types);
    }

    private void putSymbols(Map<String, Object> node, ItemSymbols item) {
        item.symbols()
                .forEach(
                        (name, value) -> {
                            if (!OMITTED.contains(name)) {
                                node.put(symbol(name), literal(name, value));
                            }
                        });
    }

    private Object literal(String symbol, Object value) {
        return switch (value) {
            case List<?> list -> list.stream().map(each -> literal(symbol, each)).toList();
            case Double number -> {
                double si =
                        prototype
                                .symbol(symbol)
                                .filter(declared -> declared.type() == SymbolType.NUMBER)
                                .map(declared -> declared.unit().toSi(number))
                                .orElse(number);
                Map<String, Object> typed = new LinkedHashMap<>();
                typed.put("@type", "xsd:double");
                typed.put("@value", Double.toString(si));
                yield typed;
            }
            default -> value;
        };
    }

    private static void putNames(Map<String, Object> node, String property, Stream<String> names) {
        List<String> all = names.toList();
        if (!all.isEmpty()) {
            node.put(property, all);
        }
    }

    private void put(
            Map<String, Object> node, TableSnapshot table, PropertyDescriptor property, int row) {
        ColumnView column = table.column(property.name());
        List<String> components = Properties.components(property);
        for (int i = 0; i < components.size(); i++) {
            String value = value(column, row, i);
            if (!value.isEmpty()) {
                node.put(iri(property, components.get(i)), value);
            }
        }
    }

    private String value(ColumnView column, int row, int component) {
        if (Properties.isText(column.descriptor())) {
            String text = Properties.text(column, row, component, snapshot);
            return column.type() == ScalarType.REF && !text.isEmpty() ? item(text) : text;
        }
        return column.unit().scale() == 1
                ? Properties.number(column, row, component)
                : Double.toString(column.unit().toSi(column.getDouble(row, component)));
    }

    private static void putRelations(Map<String, Object> node, ItemId id, Relations all) {
        for (String relation : new TreeSet<>(Relations.NAMES)) {
            List<String> related = all.of(id, relation).orElse(List.of());
            if (!related.isEmpty()) {
                node.put("reve:" + relation, related.stream().map(OntologyExport::item).toList());
            }
        }
    }

    /** Returns the IRI of a unit, and describes it at the end of the file. */
    private String unit(Unit unit) {
        String code = ucum(unit);
        String id = "unit:" + encoded(code);
        units.computeIfAbsent(
                id,
                any -> {
                    Map<String, Object> node = typed(id, "qudt:Unit");
                    node.put("rdfs:label", code);
                    node.put("qudt:ucumCode", code);
                    node.put("qudt:hasDimensionVector", "dimension:" + vector(unit));
                    return node;
                });
        return id;
    }

    /** Returns the SI unit of a dimension in the Unified Code for Units of Measure (UCUM). */
    private static String ucum(Unit unit) {
        String code =
                List.of(SiBase.values()).stream()
                        .filter(base -> unit.exponent(base) != 0)
                        .map(
                                base ->
                                        base.symbol()
                                                + (unit.exponent(base) == 1
                                                        ? ""
                                                        : unit.exponent(base)))
                        .collect(Collectors.joining("."));
        return code.isEmpty() ? "1" : code;
    }

    private static String vector(Unit unit) {
        StringBuilder vector = new StringBuilder();
        boolean isNumber = true;
        for (Map.Entry<SiBase, String> each : DIMENSIONS.entrySet()) {
            int exponent = unit.exponent(each.getKey());
            vector.append(each.getValue()).append(exponent);
            isNumber &= exponent == 0;
        }
        return vector.append('D').append(isNumber ? 1 : 0).toString();
    }

    private static String type(PropertyDescriptor property) {
        return switch (property.type()) {
            case REF -> "@id";
            case F32 -> property.unit().scale() == 1 ? "xsd:float" : "xsd:double";
            case F64 -> "xsd:double";
            case I32, U32 -> property.unit().scale() == 1 ? "xsd:integer" : "xsd:double";
        };
    }

    private static Set<String> standardProperties(WorldPrototype prototype) {
        Set<String> names = new LinkedHashSet<>();
        WorldPrototype standard = WorldPrototype.standard(prototype.name());
        standard.properties().forEach(each -> names.add(each.name()));
        standard.physicalProperties().forEach(each -> names.add(each.name()));
        List<PropertyDescriptor> optional = new ArrayList<>(prototype.propertiesOnDemand());
        if (prototype.hasSubstances()) {
            optional.addAll(prototype.ownContacts());
        }
        for (PropertyDescriptor each : prototype.properties()) {
            if (prototype.isOfJoints(each) || optional.contains(each)) {
                names.add(each.name());
            }
        }
        return names;
    }

    private String iri(PropertyDescriptor property, String component) {
        return (standardProperties.contains(property.name()) ? "property:" : "ownProperty:")
                + label(property, component);
    }

    private static String label(PropertyDescriptor property, String component) {
        return property.name() + (component.isEmpty() ? "" : "." + component);
    }

    private static String kind(String kind) {
        return (STANDARD_KINDS.contains(kind) ? "kind:" : "ownKind:") + kind;
    }

    private static String itemClass(String name) {
        return "class:" + encoded(name);
    }

    private static String symbol(String name) {
        return "symbol:" + encoded(name);
    }

    private static String item(String name) {
        return "item:" + encoded(name);
    }

    /**
     * Returns a name whose characters are all valid in an IRI: letters, digits and {@code -._~}.
     */
    private static String encoded(String name) {
        StringBuilder encoded = new StringBuilder();
        for (byte each : name.getBytes(StandardCharsets.UTF_8)) {
            boolean isPlain =
                    each >= 'a' && each <= 'z'
                            || each >= 'A' && each <= 'Z'
                            || each >= '0' && each <= '9'
                            || "-._~".indexOf(each) >= 0;
            encoded.append(isPlain ? String.valueOf((char) each) : String.format("%%%02X", each));
        }
        return encoded.toString();
    }
}
