// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.agent.port.ClusterPort;
import reve.core.frame.FrameEvent;
import reve.core.space.Box;
import reve.core.text.Visible;
import reve.core.world.ActionRefused;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.World;
import reve.core.world.WorldChange;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.function.Supplier;

/** The answers to operators' questions about a world. For the world's thread, between frames. */
final class WorldAnswers {
    /** Maximum number of changes that are stored until a client asks for them. */
    private static final int MAX_CHANGES = 10_000;

    private static final int MAX_FOUND = 1000;
    private static final String BAD = "out-of-range";

    private final Simulation simulation;
    private final Supplier<Optional<ClusterPort>> cluster;

    /** The collected changes since the last question about them; null before the first question. */
    private @Nullable List<Map<String, Object>> changes;

    private long lost;

    /**
     * @param cluster returns the cluster to which the server belongs
     */
    WorldAnswers(Simulation simulation, Supplier<Optional<ClusterPort>> cluster) {
        this.simulation = simulation;
        this.cluster = cluster;
        simulation.onPublish("changes", this::follow);
    }

    Object answer(String what, Map<String, Object> arguments) throws ActionRefused {
        return switch (what) {
            case "profile" -> RunReport.of(simulation, Double.NaN).profileFields();
            case "changes" -> changes();
            case "near" -> near(arguments);
            case "region" -> region(arguments);
            case "cluster" ->
                    cluster.get()
                            .map(ClusterPort::state)
                            .orElseThrow(
                                    () ->
                                            new ActionRefused(
                                                    "unsupported",
                                                    "this server belongs to no cluster"));
            default -> throw new ActionRefused("unsupported", "this server answers no " + what);
        };
    }

    private List<Object> near(Map<String, Object> arguments) throws ActionRefused {
        double[] at = point(arguments, "location");
        World world = simulation.world();
        int most = (int) number(arguments, "most", MAX_FOUND, MAX_FOUND);
        List<ItemId> found =
                arguments.containsKey("distance")
                        ? world.space()
                                .inSphere(
                                        at[0],
                                        at[1],
                                        at[2],
                                        number(arguments, "distance", 0, Double.MAX_VALUE))
                        : world.space().nearest(at[0], at[1], at[2], most);
        return items(found.subList(0, Math.min(most, found.size())));
    }

    private List<Object> region(Map<String, Object> arguments) throws ActionRefused {
        double[] from = point(arguments, "from");
        double[] to = point(arguments, "to");
        try {
            List<ItemId> found =
                    simulation
                            .world()
                            .space()
                            .inBox(new Box(from[0], from[1], from[2], to[0], to[1], to[2]));
            return items(found.subList(0, Math.min(MAX_FOUND, found.size())));
        } catch (IllegalArgumentException noBox) {
            throw new ActionRefused(BAD, String.valueOf(noBox.getMessage()), noBox);
        }
    }

    private List<Object> items(List<ItemId> found) {
        List<Object> items = new ArrayList<>();
        for (ItemId id : found) {
            Item item = simulation.world().item(id);
            double[] at = item.physical().location();
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("name", item.name());
            fields.put("location", List.of(at[0], at[1], at[2]));
            items.add(fields);
        }
        return items;
    }

    private static double[] point(Map<String, Object> arguments, String name) throws ActionRefused {
        if (arguments.get(name) instanceof List<?> list && list.size() == 3) {
            return list.stream().mapToDouble(each -> ((Number) each).doubleValue()).toArray();
        }
        throw new ActionRefused(BAD, name + ": expected a list of three numbers [m]");
    }

    private static double number(
            Map<String, Object> arguments, String name, double otherwise, double most)
            throws ActionRefused {
        Object value = arguments.getOrDefault(name, otherwise);
        if (value instanceof Double number && number >= 0 && number <= most) {
            return number;
        }
        throw new ActionRefused(
                BAD,
                name
                        + " is "
                        + Visible.shortened(String.valueOf(value))
                        + ", expected a number from 0 to "
                        + most);
    }

    /** Returns the changes since the last question. The first call begins to collect changes. */
    private Map<String, Object> changes() {
        List<Map<String, Object>> seen = changes == null ? List.of() : changes;
        Map<String, Object> answer = new LinkedHashMap<>();
        answer.put("changes", seen);
        answer.put("lost", lost);
        changes = new ArrayList<>();
        lost = 0;
        return answer;
    }

    private void follow(FrameEvent frame) {
        List<Map<String, Object>> into = changes;
        if (into == null) {
            return;
        }
        lost += frame.world().changesLost();
        for (WorldChange change : frame.world().changes()) {
            if (into.size() < MAX_CHANGES) {
                into.add(describe(frame, change));
            } else {
                lost++;
            }
        }
    }

    private static Map<String, Object> describe(FrameEvent frame, WorldChange change) {
        World world = frame.world();
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("frame", frame.frame());
        fields.put("change", change.getClass().getSimpleName().toLowerCase(Locale.ROOT));
        switch (change) {
            case WorldChange.Added added ->
                    fields.put(
                            "items",
                            added.definitions().stream().map(ItemDefinition::name).toList());
            case WorldChange.Removed removed -> fields.put("item", removed.name());
            case WorldChange.Renamed renamed -> {
                fields.put("item", renamed.from());
                fields.put("to", renamed.to());
            }
            case WorldChange.Attached attached -> {
                fields.put("item", name(world, attached.item()));
                fields.put("to", name(world, attached.to().parent()));
            }
            case WorldChange.Detached detached -> fields.put("item", name(world, detached.item()));
            case WorldChange.Edited edited -> {
                fields.put("item", name(world, edited.item()));
                fields.put(
                        "property",
                        edited.aspect().name().toLowerCase(Locale.ROOT) + "." + edited.property());
                if (edited.to() != null) {
                    fields.put("to", text(edited.to()));
                }
            }
            case WorldChange.Pushed pushed -> {
                fields.put("item", name(world, pushed.force().item()));
                fields.put("force", pushed.force().newtons());
            }
            case WorldChange.ColumnEdited column ->
                    fields.put("property", column.kind() + "." + column.property());
            case WorldChange.Restored restored -> fields.put("to", restored.frame());
        }
        return fields;
    }

    private static Object text(Object value) {
        return value instanceof Number
                        || value instanceof Boolean
                        || value instanceof List<?> list
                                && list.stream().allMatch(Number.class::isInstance)
                ? value
                : String.valueOf(value);
    }

    private static String name(World world, ItemId id) {
        return world.find(id).map(Item::name).orElse(id.toString());
    }
}
