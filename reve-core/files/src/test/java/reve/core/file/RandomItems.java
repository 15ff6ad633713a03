// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.ItemDefinition;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.Voice;
import reve.core.world.WorldPrototype;

import java.util.Arrays;
import java.util.Random;
import java.util.Set;

/** Items of kind body with arbitrary aspects, for tests that write and read them. */
final class RandomItems {
    private static final String[] TEXTS = {
        "",
        " ",
        "x",
        "toy",
        "true",
        "no",
        "null",
        "~",
        "3",
        "1e5",
        "-",
        "- a",
        "a: b",
        "a #b",
        "#b",
        "'",
        "\"",
        "a\nb",
        " a\n\n b ",
        "\t",
        "\\",
        "{i}",
        "$p",
        "[1]",
        "é",
        "\ud83d\ude00",
        "\u2028",
        "\u0085",
        "\ufeff",
        "\u0007",
        "%x",
        "&a",
        "*a",
        "!t",
        "| ",
        "> x",
        "@",
        "`",
        "a,b",
        "?",
        "? a",
        "=",
        "<<",
        "two  spaces",
        "trailing ",
        "a very long text ".repeat(30),
        "0x1f",
        "0o17",
        ".inf",
        ".nan",
        "1_000",
        "12:30",
        "2026-1-1"
    };

    private RandomItems() {}

    static ItemDefinition body(Random random, WorldPrototype prototype, String name) {
        ItemDefinition.Builder item = ItemDefinition.named(name);
        if (random.nextBoolean()) {
            item.shape(shape(random));
        }
        if (random.nextBoolean()) {
            item.colour(String.format("#%08x", random.nextInt()));
        }
        if (random.nextBoolean()) {
            item.at(real(random, prototype), real(random, prototype), real(random, prototype));
        }
        if (random.nextBoolean()) {
            item.orientation(
                    random.nextGaussian(),
                    random.nextGaussian(),
                    random.nextGaussian(),
                    random.nextGaussian());
        }
        for (int i = random.nextInt(4); i > 0; i--) {
            item.symbol(
                    "s" + i,
                    switch (random.nextInt(3)) {
                        case 0 -> text(random);
                        case 1 -> random.nextBoolean();
                        default -> number(random);
                    });
        }
        for (PropertyDescriptor property : prototype.properties()) {
            if (property.kind().equals(WorldPrototype.BODY) && random.nextInt(4) == 0) {
                double[] values = new double[property.components()];
                Arrays.setAll(values, i -> real(random, prototype));
                Arrays.setAll(values, i -> values[i] < property.minimum() ? -values[i] : values[i]);
                item.physics(property.name(), values);
            }
        }
        if (random.nextInt(4) == 0) {
            item.sensor(
                    Sensor.sight("eyes", random.nextDouble() * 100 + 0.1)
                            .withFieldOfView(random.nextDouble() * 3 + 0.1)
                            .withLineOfSight()
                            .withEvery(1 + random.nextInt(9))
                            .withSymbols(Set.of("s1", "class")));
            item.sensor(Sensor.touch("skin").withAspects(Set.of(Sensor.Aspect.ACCESS)));
            item.sensor(Sensor.hearing("ears", distance(random)));
            item.voice(new Voice(distance(random), distance(random)));
        }
        return item.build();
    }

    /** Returns a distance [m]; it may be infinite. */
    private static double distance(Random random) {
        return random.nextInt(4) == 0 ? Double.POSITIVE_INFINITY : random.nextDouble() * 100 + 0.1;
    }

    static String text(Random random) {
        return TEXTS[random.nextInt(TEXTS.length)];
    }

    /** Returns any finite number that a real column of the prototype can hold. */
    static double real(Random random, WorldPrototype prototype) {
        double number = number(random);
        return prototype.realType() == ScalarType.F64
                ? number
                : Math.abs(number) > Float.MAX_VALUE || (float) number == 0 ? 0.5 : number;
    }

    private static double number(Random random) {
        return switch (random.nextInt(7)) {
            case 0 -> 0;
            case 1 -> -0.0;
            case 2 -> random.nextInt(2000) - 1000;
            case 3 -> random.nextGaussian();
            case 4 -> Double.longBitsToDouble(random.nextLong(0x7ff0_0000_0000_0000L));
            default -> random.nextInt() * 0.1;
        };
    }

    private static Shape shape(Random random) {
        return switch (random.nextInt(6)) {
            case 0 -> Shape.sphere(random.nextDouble() + 0.1);
            case 1 -> Shape.box(1 + random.nextInt(9), random.nextDouble() + 0.1, 1e-9);
            case 2 -> Shape.plane(random.nextDouble() + 0.1, 1e12);
            case 3 -> Shape.capsule(0.1, random.nextDouble() + 0.2);
            case 4 -> Shape.cylinder(random.nextDouble() + 0.1, 7);
            case 5 -> Shape.ellipsoid(random.nextDouble() + 0.1, 1e-9, 1 + random.nextInt(9));
            default ->
                    Shape.mesh(
                            new float[] {
                                0,
                                0,
                                0,
                                random.nextFloat(),
                                0,
                                0,
                                0,
                                1e-30f,
                                random.nextFloat(),
                                3e38f,
                                -0.0f,
                                1
                            },
                            new int[] {0, 1, 2, 3, 2, 1});
        };
    }

    /** Returns whether two lists of numbers have the same bits. */
    static boolean bits(double[] a, double[] b) {
        return Arrays.equals(
                Arrays.stream(a).mapToLong(Double::doubleToRawLongBits).toArray(),
                Arrays.stream(b).mapToLong(Double::doubleToRawLongBits).toArray());
    }
}
