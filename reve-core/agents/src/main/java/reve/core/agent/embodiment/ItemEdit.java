// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import reve.core.agent.protocol.Text;
import reve.core.world.ActionRefused;
import reve.core.world.Colour;
import reve.core.world.ConnectionLook;
import reve.core.world.Item;
import reve.core.world.LevelChange;
import reve.core.world.Possible;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.SymbolBytes;
import reve.core.world.World;

import java.util.Arrays;
import java.util.List;
import java.util.Optional;
import java.util.regex.Pattern;

/**
 * An operator's edit of one property of an item, by the name of the property. For the world's
 * thread only.
 */
final class ItemEdit {

    private static final Pattern SYMBOL = Pattern.compile("[A-Za-z][A-Za-z0-9_-]{0,63}");

    private ItemEdit() {}

    /**
     * Sets the property.
     *
     * @param frame number of the frame, for events
     * @throws ActionRefused if the item or property does not exist, or the value is invalid
     */
    static void apply(World world, long frame, AgentInput.Edit edit) throws ActionRefused {
        Item item =
                world.find(edit.item())
                        .orElseThrow(
                                () ->
                                        new ActionRefused(
                                                "no-such-item",
                                                "the world has no item "
                                                        + Text.quote(edit.item())));
        String[] path = edit.property().split("\\.", 2);
        if (path.length < 2) {
            throw noSuchProperty(edit.property());
        }
        try {
            switch (path[0]) {
                case "physical" -> setPhysical(world, item, path[1], edit.value());
                case "physics" ->
                        setPhysics(
                                world, item, path[1], numbers(item, edit.property(), edit.value()));
                case "semantic" -> setSymbol(world, frame, item, path[1], edit.value());
                default -> throw noSuchProperty(edit.property());
            }
        } catch (IllegalArgumentException | IllegalStateException e) {
            throw new ActionRefused("edit-refused", String.valueOf(e.getMessage()));
        }
    }

    private static void setPhysics(World world, Item item, String property, double[] values)
            throws ActionRefused {
        Optional<PropertyDescriptor> column =
                world.prototype()
                        .find(item.kind(), property)
                        .filter(known -> known.components() == values.length);
        Optional<String> why = column.flatMap(known -> Possible.refusal(known, values));
        if (why.isPresent()) {
            throw outOfRange(item, "physics." + property, values, why.get());
        }
        item.physics().set(property, values); // this call throws an exception for other names
        world.arrests().suspect(item.id());
    }

    private static ActionRefused outOfRange(
            Item item, String property, double[] values, String why) {
        return new ActionRefused(
                "out-of-range",
                "item "
                        + item.name()
                        + ": "
                        + property
                        + " is "
                        + (values.length == 1 ? values[0] : Arrays.toString(values))
                        + "; "
                        + why);
    }

    /** Sets a symbol. The name must be valid in a world file, so that a saved world can be read. */
    private static void setSymbol(World world, long frame, Item item, String symbol, Object value)
            throws ActionRefused {
        if (item.isLevel(symbol)) {
            LevelChange.prepare(world, item, value).make(frame);
            return;
        }
        if (!SYMBOL.matcher(symbol).matches()) {
            throw new IllegalArgumentException(
                    "item "
                            + item.name()
                            + ": "
                            + Text.quote(symbol)
                            + " is no name of a symbol; expected a letter, then letters, digits, -"
                            + " or _, at most 64 in all");
        }
        SymbolBytes.require(world, SymbolBytes.growth(item, symbol, value), "edit-refused");
        item.semantic().set(symbol, value);
    }

    private static void setPhysical(World world, Item item, String property, Object value)
            throws ActionRefused {
        switch (property) {
            case "location" -> {
                double[] at = numbers(item, property, value, 3);
                item.physical().setLocation(at[0], at[1], at[2]);
                world.arrests().suspect(item.id());
            }
            case "orientation" -> {
                double[] turn = numbers(item, property, value, 4);
                item.physical().setOrientation(turn[0], turn[1], turn[2], turn[3]);
            }
            case "colour" -> item.physical().setColour(colour(item, value));
            case ConnectionLook.WIDTH ->
                    item.physical().setWidth(numbers(item, property, value, 1)[0]);
            default -> throw noSuchProperty("physical." + property);
        }
    }

    private static ActionRefused noSuchProperty(String property) {
        return new ActionRefused(
                "no-such-property",
                "there is no property "
                        + Text.quote(property)
                        + "; expected physical.location, physical.orientation, physical.colour,"
                        + " physical.width, physics.NAME or semantic.NAME");
    }

    private static Colour colour(Item item, Object value) {
        try {
            return Colour.parse(String.valueOf(value));
        } catch (IllegalArgumentException e) {
            throw new IllegalArgumentException("item " + item.name() + ": " + e.getMessage(), e);
        }
    }

    private static double[] numbers(Item item, String property, Object value, int count)
            throws ActionRefused {
        double[] numbers = numbers(item, property, value);
        if (numbers.length != count) {
            throw new IllegalArgumentException(
                    "item "
                            + item.name()
                            + ": "
                            + property
                            + " is "
                            + numbers.length
                            + " numbers, expected "
                            + count);
        }
        return numbers;
    }

    private static double[] numbers(Item item, String property, Object value) throws ActionRefused {
        double[] numbers = given(item, property, value);
        for (double number : numbers) {
            Optional<String> why = ScalarType.F64.refusal(number);
            if (why.isPresent()) {
                throw outOfRange(item, property, new double[] {number}, why.get());
            }
        }
        return numbers;
    }

    private static double[] given(Item item, String property, Object value) {
        return switch (value) {
            case Double number -> new double[] {number};
            case List<?> list -> list.stream().mapToDouble(number -> (Double) number).toArray();
            default ->
                    throw new IllegalArgumentException(
                            "item "
                                    + item.name()
                                    + ": "
                                    + property
                                    + " is "
                                    + (value instanceof String text ? Text.quote(text) : value)
                                    + ", expected numbers");
        };
    }
}
