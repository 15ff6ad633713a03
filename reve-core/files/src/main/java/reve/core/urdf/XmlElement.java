// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import java.io.ByteArrayInputStream;
import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Deque;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

import javax.xml.stream.XMLInputFactory;
import javax.xml.stream.XMLStreamConstants;
import javax.xml.stream.XMLStreamException;
import javax.xml.stream.XMLStreamReader;

/**
 * An element of an XML file.
 *
 * @param file name of the file, for messages
 * @param line number of the line in which the start tag ends, from 1
 */
record XmlElement(
        String file,
        int line,
        String name,
        Map<String, String> attributes,
        List<XmlElement> children) {
    private static final int MAX_DEPTH = 32;
    private static final int MAX_ELEMENTS = 200_000;

    /** Maximum length [m]. A shape may have ten times this size. */
    private static final double MAX_METRES = 1e11;

    /** Reads the root element of a file. Ignores document type declarations. */
    static XmlElement read(String file, byte[] bytes) throws RobotFileException {
        XMLInputFactory factory = XMLInputFactory.newDefaultFactory();
        factory.setProperty(XMLInputFactory.SUPPORT_DTD, false);
        factory.setProperty(XMLInputFactory.IS_SUPPORTING_EXTERNAL_ENTITIES, false);
        try {
            return read(file, factory.createXMLStreamReader(new ByteArrayInputStream(bytes)));
        } catch (XMLStreamException broken) {
            int line = broken.getLocation() == null ? 1 : broken.getLocation().getLineNumber();
            String message = String.valueOf(broken.getMessage());
            String last = message.substring(message.lastIndexOf("Message: ") + 1);
            throw new RobotFileException(
                    file
                            + ":"
                            + Math.max(line, 1)
                            + ": this is not XML: "
                            + last.replaceFirst("^essage: ", "").lines().findFirst().orElse(""));
        }
    }

    private static XmlElement read(String file, XMLStreamReader reader)
            throws XMLStreamException, RobotFileException {
        Deque<XmlElement> open = new ArrayDeque<>();
        int count = 0;
        while (reader.hasNext()) {
            int event = reader.next();
            if (event == XMLStreamConstants.START_ELEMENT) {
                Map<String, String> attributes = new LinkedHashMap<>();
                for (int i = 0; i < reader.getAttributeCount(); i++) {
                    attributes.put(reader.getAttributeLocalName(i), reader.getAttributeValue(i));
                }
                XmlElement element =
                        new XmlElement(
                                file,
                                reader.getLocation().getLineNumber(),
                                reader.getLocalName(),
                                attributes,
                                new ArrayList<>());
                if (!open.isEmpty()) {
                    open.peek().children.add(element);
                }
                if (open.size() == MAX_DEPTH || ++count > MAX_ELEMENTS) {
                    throw element.problem(
                            "the file has more than "
                                    + MAX_DEPTH
                                    + " levels or "
                                    + MAX_ELEMENTS
                                    + " elements");
                }
                open.push(element);
            } else if (event == XMLStreamConstants.END_ELEMENT) {
                XmlElement element = open.pop();
                if (open.isEmpty()) {
                    return element;
                }
            }
        }
        throw new RobotFileException(file + ":1: the file has no element");
    }

    /** Refuses lengths that are not positive, or that no shape can have. */
    void requireLengths(double... lengths) throws RobotFileException {
        for (double length : lengths) {
            if (!(length > 0 && length <= MAX_METRES)) {
                throw problem(
                        "a length is " + length + " m, expected more than 0 and at most 1e11 m");
            }
        }
    }

    /** Returns an exception whose message names the position of this element. */
    RobotFileException problem(String message) {
        return new RobotFileException(place() + ": " + message);
    }

    /** Returns a copy of this element with other attributes. */
    XmlElement with(Map<String, String> other) {
        return new XmlElement(file, line, name, other, children);
    }

    String place() {
        return file + ":" + line;
    }

    Optional<XmlElement> child(String wanted) {
        return children.stream().filter(child -> child.name.equals(wanted)).findFirst();
    }

    List<XmlElement> all(String wanted) {
        return children.stream().filter(child -> child.name.equals(wanted)).toList();
    }

    Optional<String> find(String attribute) {
        return Optional.ofNullable(attributes.get(attribute));
    }

    String text(String attribute) throws RobotFileException {
        String text = attributes.get(attribute);
        if (text == null || text.isBlank()) {
            throw problem("<" + name + "> has no attribute " + attribute + ", which it must have");
        }
        return text.strip();
    }

    /**
     * Returns the finite numbers of an attribute, which are separated by blanks. Returns the
     * default if the attribute is missing.
     */
    double[] numbers(String attribute, double... otherwise) throws RobotFileException {
        return find(attribute).isEmpty()
                ? otherwise
                : list(attribute, otherwise.length, otherwise.length);
    }

    /**
     * Returns the finite numbers of an attribute, which must be present.
     *
     * @param least minimum number of them
     * @param most maximum number of them
     */
    double[] list(String attribute, int least, int most) throws RobotFileException {
        String[] words = text(attribute).split("\\s+");
        double[] numbers = new double[words.length];
        boolean wrong = words.length < least || words.length > most;
        for (int i = 0; !wrong && i < numbers.length; i++) {
            try {
                numbers[i] = Double.parseDouble(words[i]);
                wrong = !Double.isFinite(numbers[i]);
            } catch (NumberFormatException noNumber) {
                wrong = true;
            }
        }
        if (wrong) {
            throw problem(
                    "<"
                            + name
                            + " "
                            + attribute
                            + "=\""
                            + attributes.get(attribute)
                            + "\">: expected "
                            + (most == 1
                                    ? "a number"
                                    : (least < most ? least + " to " : "")
                                            + most
                                            + " numbers, separated by blanks"));
        }
        return numbers;
    }

    double number(String attribute, double otherwise) throws RobotFileException {
        return numbers(attribute, otherwise)[0];
    }

    /** Returns the number of an attribute, which must be present. */
    double number(String attribute) throws RobotFileException {
        text(attribute);
        return number(attribute, 0);
    }
}
