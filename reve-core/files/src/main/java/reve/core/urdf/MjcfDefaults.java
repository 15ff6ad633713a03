// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;

/** The default values of attributes in an MJCF file, by class and element. */
final class MjcfDefaults {
    private static final String MAIN = "main";

    /** Key of the default values of actuators, which all kinds of actuators share. */
    private static final String ACTUATOR = "actuator";

    static final Set<String> ACTUATORS =
            Set.of(
                    "general",
                    "motor",
                    "position",
                    "velocity",
                    "intvelocity",
                    "damper",
                    "cylinder",
                    "muscle",
                    "adhesion",
                    "dcmotor");

    /** Maximum number of values that classes inherit in total. */
    private static final int MAX_INHERITED = 1_000_000;

    private final Map<String, Map<String, Map<String, String>>> classes = new HashMap<>();
    private int inheritedCount;

    /**
     * @param elements the elements {@code default} of the file
     */
    MjcfDefaults(List<XmlElement> elements) throws RobotFileException {
        Map<String, Map<String, String>> main = new HashMap<>();
        String called = MAIN;
        if (!elements.isEmpty()) {
            called = elements.getFirst().find("class").orElse(MAIN);
        }
        classes.put(MAIN, main);
        classes.put(called, main);
        for (XmlElement element : elements) {
            if (!element.find("class").orElse(called).equals(called)) {
                throw element.problem(
                        "the outermost default class is "
                                + element.text("class")
                                + ", expected "
                                + called
                                + ", the name of the first one");
            }
            read(element, main);
        }
    }

    private void read(XmlElement element, Map<String, Map<String, String>> values)
            throws RobotFileException {
        for (XmlElement child : element.children()) {
            if (!child.name().equals("default")) {
                values.computeIfAbsent(kind(child.name()), _ -> new LinkedHashMap<>())
                        .putAll(child.attributes());
            }
        }
        for (XmlElement child : element.all("default")) {
            Map<String, Map<String, String>> inherited = new HashMap<>();
            for (Map.Entry<String, Map<String, String>> kind : values.entrySet()) {
                inheritedCount += 1 + kind.getValue().size();
                if (inheritedCount > MAX_INHERITED) {
                    throw child.problem(
                            "the default classes inherit more than " + MAX_INHERITED + " values");
                }
                inherited.put(kind.getKey(), new LinkedHashMap<>(kind.getValue()));
            }
            String name = child.text("class");
            if (classes.put(name, inherited) != null) {
                throw child.problem("a second default class has the name " + name);
            }
            read(child, inherited);
        }
    }

    private static String kind(String element) {
        return ACTUATORS.contains(element) ? ACTUATOR : element;
    }

    /**
     * Returns an element with the default values of its class.
     *
     * @param outer class of the element if it states none; empty for the class {@code main}
     */
    XmlElement resolve(XmlElement element, String outer) throws RobotFileException {
        String name = element.find("class").orElse(outer.isEmpty() ? MAIN : outer);
        Map<String, Map<String, String>> values = classes.get(name);
        if (values == null) {
            throw element.problem("there is no default class " + name);
        }
        Map<String, String> defaults = values.getOrDefault(kind(element.name()), Map.of());
        Map<String, String> merged = new LinkedHashMap<>(defaults);
        merged.putAll(element.attributes());
        return element.with(merged);
    }

    /**
     * Returns the default class for the children of an element, from its attribute {@code
     * childclass}. The class must exist.
     *
     * @param outer class if the element has no such attribute
     */
    String childClass(XmlElement element, String outer) throws RobotFileException {
        String name = element.find("childclass").orElse(outer);
        if (!name.isEmpty() && !classes.containsKey(name)) {
            throw element.problem("there is no default class " + name);
        }
        return name;
    }
}
