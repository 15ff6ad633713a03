// SPDX-License-Identifier: Apache-2.0
package reve.core.plugin;

import reve.core.unit.Unit;
import reve.core.world.Item;
import reve.core.world.SensorProvider;
import reve.core.world.SymbolProvider;

import java.util.List;
import java.util.Locale;
import java.util.Optional;

/** Providers of symbols and sensors that tests find on the class path. */
public final class TestProviders {
    private TestProviders() {}

    /** The name in capital letters. Items with certain names break a rule of symbols. */
    public static final class Loud implements SymbolProvider {
        @Override
        public String name() {
            return "test.loud";
        }

        @Override
        public String doc() {
            return "Its name in capital letters.";
        }

        @Override
        public Optional<Object> value(Item item) {
            return switch (item.name()) {
                case "throws" -> throw new IllegalStateException("out of order");
                case "recurses" -> value(item);
                case "meddles" -> {
                    item.semantic().set("meddled", true);
                    yield Optional.empty();
                }
                case "quiet" -> Optional.empty();
                case "wrong" -> Optional.of(List.of(Double.NaN));
                default -> Optional.of(item.name().toUpperCase(Locale.ROOT));
            };
        }
    }

    /** Measures a place. */
    public static final class Place implements SensorProvider {
        @Override
        public String name() {
            return "test.place";
        }

        @Override
        public String doc() {
            return "Measures where the body is.";
        }

        @Override
        public List<Quantity> quantities() {
            return List.of(
                    new Quantity("place", 3, Unit.parse("m")),
                    new Quantity("time", 1, Unit.parse("s")));
        }

        @Override
        public void measure(Item body, double timeSeconds, double[] numbers) {
            System.arraycopy(body.physical().location(), 0, numbers, 0, 3);
            numbers[3] = timeSeconds;
        }
    }
}
