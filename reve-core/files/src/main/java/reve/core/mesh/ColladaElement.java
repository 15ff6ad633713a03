// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import java.io.ByteArrayInputStream;
import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Deque;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

import javax.xml.stream.XMLInputFactory;
import javax.xml.stream.XMLStreamConstants;
import javax.xml.stream.XMLStreamException;
import javax.xml.stream.XMLStreamReader;

/**
 * An element of a COLLADA file. Only numbers and short texts of the elements that the reader knows
 * are kept. For one thread.
 */
final class ColladaElement {
    private static final int MAX_DEPTH = 96;
    private static final int MAX_ELEMENTS = 200_000;
    private static final int MAX_WORD = 64;
    private static final int MAX_ATTRIBUTES = 1_000_000;

    /** Maximum number of numbers in a file. */
    private static final int MAX_NUMBERS = 1 << 24;

    /** Maximum number of digits of a whole number that needs no parser. */
    private static final int SHORT = 7;

    /** Attributes that the reader uses. */
    private static final Set<String> ATTRIBUTES =
            Set.of(
                    "id",
                    "source",
                    "url",
                    "target",
                    "symbol",
                    "semantic",
                    "offset",
                    "count",
                    "stride",
                    "material",
                    "meter");

    /** Elements that contain numbers, which may be many. */
    private static final Set<String> NUMBERS =
            Set.of("float_array", "p", "vcount", "matrix", "translate", "rotate", "scale", "color");

    private final Document document;
    private final String name;
    private final int line;
    private final Map<String, String> attributes = new HashMap<>();
    private final List<ColladaElement> children = new ArrayList<>();
    private float[] numbers = {};
    private int count;

    /** The last word, which is still incomplete while the text arrives in pieces. */
    private final StringBuilder word = new StringBuilder();

    /** The counts of a whole file. */
    private static final class Document {
        private final Sources sources;
        private final Map<String, ColladaElement> byId;
        private int elements;
        private int attributes;
        private int numbers;

        Document(Sources sources, Map<String, ColladaElement> byId) {
            this.sources = sources;
            this.byId = byId;
        }
    }

    private ColladaElement(Document document, String name, int line) {
        this.document = document;
        this.name = name;
        this.line = line;
    }

    /**
     * Reads the root element of a file.
     *
     * @param byId receives the first element with each id
     */
    static ColladaElement read(byte[] bytes, Sources sources, Map<String, ColladaElement> byId)
            throws AssetException {
        XmlBounds.require(bytes, sources);
        XMLInputFactory factory = XMLInputFactory.newDefaultFactory();
        factory.setProperty(XMLInputFactory.SUPPORT_DTD, false);
        factory.setProperty(XMLInputFactory.IS_SUPPORTING_EXTERNAL_ENTITIES, false);
        factory.setProperty(XMLInputFactory.IS_REPLACING_ENTITY_REFERENCES, false);
        try {
            XMLStreamReader reader = factory.createXMLStreamReader(new ByteArrayInputStream(bytes));
            return read(reader, new Document(sources, byId));
        } catch (XMLStreamException broken) {
            int at = broken.getLocation() == null ? 1 : broken.getLocation().getLineNumber();
            String message = String.valueOf(broken.getMessage());
            String last =
                    message.substring(message.lastIndexOf("Message: ") + 1)
                            .replaceFirst("^essage: ", "")
                            .lines()
                            .findFirst()
                            .orElse("");
            throw sources.refuse(
                    "not COLLADA: line "
                            + Math.max(at, 1)
                            + ": this is not XML: "
                            + Reason.of(last, "it is damaged"));
        } catch (RuntimeException broken) {
            // The parser of the JDK throws unchecked exceptions for some malformed files.
            throw sources.refuse("not COLLADA: line 1: this is not XML: it is damaged");
        }
    }

    private static ColladaElement read(XMLStreamReader reader, Document document)
            throws XMLStreamException, AssetException {
        Deque<ColladaElement> open = new ArrayDeque<>();
        while (reader.hasNext()) {
            switch (reader.next()) {
                case XMLStreamConstants.START_ELEMENT -> {
                    ColladaElement element = begin(reader, document);
                    if (open.size() == MAX_DEPTH || ++document.elements > MAX_ELEMENTS) {
                        throw element.refuse(
                                "more than "
                                        + MAX_DEPTH
                                        + " levels or "
                                        + MAX_ELEMENTS
                                        + " elements");
                    }
                    element.find("id").ifPresent(id -> document.byId.putIfAbsent(id, element));
                    if (!open.isEmpty()) {
                        open.peek().children.add(element);
                    }
                    open.push(element);
                }
                case XMLStreamConstants.CHARACTERS, XMLStreamConstants.CDATA -> {
                    if (!open.isEmpty()) {
                        open.peek()
                                .text(
                                        reader.getTextCharacters(),
                                        reader.getTextStart(),
                                        reader.getTextLength());
                    }
                }
                case XMLStreamConstants.END_ELEMENT -> {
                    ColladaElement element = open.pop();
                    element.end();
                    if (open.isEmpty()) {
                        return element;
                    }
                }
                case XMLStreamConstants.DTD, XMLStreamConstants.ENTITY_REFERENCE ->
                        throw document.sources.refuse(
                                "not COLLADA: line "
                                        + reader.getLocation().getLineNumber()
                                        + ": a document type or an entity, expected neither;"
                                        + " remove it");
                default -> {}
            }
        }
        throw document.sources.refuse("not COLLADA: the file has no element");
    }

    private static ColladaElement begin(XMLStreamReader reader, Document document)
            throws AssetException {
        var element =
                new ColladaElement(
                        document, reader.getLocalName(), reader.getLocation().getLineNumber());
        document.attributes += reader.getAttributeCount() + reader.getNamespaceCount();
        if (document.attributes > MAX_ATTRIBUTES) {
            throw element.refuse("the file has more than " + MAX_ATTRIBUTES + " attributes");
        }
        for (int i = 0; i < reader.getAttributeCount(); i++) {
            if (ATTRIBUTES.contains(reader.getAttributeLocalName(i))) {
                element.attributes.put(
                        reader.getAttributeLocalName(i), reader.getAttributeValue(i));
            }
        }
        return element;
    }

    private boolean isNumeric() {
        return NUMBERS.contains(name);
    }

    /** Takes a piece of the element's text. A word may be divided among pieces. */
    private void text(char[] chars, int from, int length) throws AssetException {
        if (!isNumeric()) {
            word.append(chars, from, Math.min(length, MAX_WORD - word.length()));
            return;
        }
        for (int i = from; i < from + length; i++) {
            if (chars[i] > ' ') {
                if (word.length() == MAX_WORD) {
                    throw refuse("`" + word + "…` is no number");
                }
                word.append(chars[i]);
            } else if (!word.isEmpty()) {
                number();
            }
        }
    }

    private void end() throws AssetException {
        if (isNumeric()) {
            if (!word.isEmpty()) {
                number();
            }
            Sources sources = document.sources;
            sources.budget().takeBytes(sources.path(), 0); // checks the time
        }
    }

    private void number() throws AssetException {
        if (count == numbers.length) {
            numbers = Arrays.copyOf(numbers, Math.max(16, count + count / 2));
        }
        if (++document.numbers > MAX_NUMBERS) {
            throw refuse("the file has more than " + MAX_NUMBERS + " numbers; simplify the mesh");
        }
        int whole = whole(word);
        try {
            numbers[count++] = whole >= 0 ? whole : Float.parseFloat(word.toString());
        } catch (NumberFormatException none) {
            throw refuse("`" + word + "` is no number");
        }
        word.setLength(0);
    }

    /** Returns a short word of digits as a number; -1 for other words. */
    private static int whole(CharSequence word) {
        int number = word.length() > SHORT ? -1 : 0;
        for (int i = 0; i < word.length() && number >= 0; i++) {
            int digit = word.charAt(i) - '0';
            number = digit < 0 || digit > 9 ? -1 : 10 * number + digit;
        }
        return number;
    }

    String name() {
        return name;
    }

    /** Returns the number of numbers in the element. */
    int count() {
        return count;
    }

    /** Returns one of the numbers in the element. */
    float number(int at) {
        return numbers[at];
    }

    /** Returns one of the numbers in the element as an index, from 0. */
    int index(int at) throws AssetException {
        float value = numbers[at];
        int index = (int) value;
        if (index != value || index < 0 || index >= MAX_INDEX) {
            throw refuse("found " + value + ", expected the number of a vertex");
        }
        return index;
    }

    /** Largest index + 1. All smaller whole numbers are exact as floats. */
    private static final int MAX_INDEX = 1 << 24;

    /** Returns the numbers in the element. */
    double[] numbers(int expected) throws AssetException {
        if (count != expected) {
            throw refuse("found " + count + " numbers, expected " + expected);
        }
        double[] all = new double[count];
        for (int i = 0; i < count; i++) {
            all[i] = numbers[i];
            if (!Float.isFinite(numbers[i])) {
                throw refuse("found " + numbers[i] + ", expected a finite number");
            }
        }
        return all;
    }

    /** Returns the short text in the element. */
    String word() {
        return word.toString().strip();
    }

    List<ColladaElement> children() {
        return children;
    }

    List<ColladaElement> all(String wanted) {
        return children.stream().filter(child -> child.name.equals(wanted)).toList();
    }

    Optional<ColladaElement> child(String wanted) {
        return children.stream().filter(child -> child.name.equals(wanted)).findFirst();
    }

    /** Returns the nested child that a sequence of names leads to. */
    Optional<ColladaElement> path(String... names) {
        Optional<ColladaElement> element = Optional.of(this);
        for (String wanted : names) {
            element = element.flatMap(each -> each.child(wanted));
        }
        return element;
    }

    Optional<String> find(String attribute) {
        return Optional.ofNullable(attributes.get(attribute));
    }

    /** Returns an attribute that is a whole number from 0 to 2^24. */
    int whole(String attribute, int otherwise) throws AssetException {
        Optional<String> text = find(attribute);
        if (text.isEmpty()) {
            return otherwise;
        }
        try {
            int value = Integer.parseInt(text.get().strip());
            if (value >= 0 && value < MAX_INDEX) {
                return value;
            }
        } catch (NumberFormatException none) {
            // The exception below reports the value.
        }
        throw refuse(
                attribute
                        + ": found `"
                        + text.get().substring(0, Math.min(MAX_WORD, text.get().length()))
                        + "`, expected a whole number");
    }

    /** Returns an exception whose message names the line and the element. */
    AssetException refuse(String reason) {
        return document.sources.refuse("not COLLADA: line " + line + ": <" + name + ">: " + reason);
    }
}
