// SPDX-License-Identifier: Apache-2.0
package reve.agent.examples;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.AgentException;
import reve.agent.DisconnectedException;
import reve.agent.Perception;
import reve.agent.Perception.Item;
import reve.agent.Perception.Location;
import reve.agent.WorldEvent;

import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.TreeMap;

/**
 * An example agent that shows the speed of items by their colours. It watches all items. It paints
 * each item that has an action for this, from blue (at rest) to red (the highest speed so far). Its
 * last line on standard output is a JSON summary.
 */
public final class Painter {

    private static final int PERCEIVE_EVERY_FRAMES = 6;
    private static final double PAINT_EVERY_SECONDS = 0.5;
    private static final String USAGE =
            """
            usage: Painter [--host 127.0.0.1] [--port 7777] [--name painter] [--seconds 5]
              --seconds  how long to stay, in the world's time\
            """;

    private final AgentClient agent;
    private final double seconds;
    private final Map<String, Object> summary = new LinkedHashMap<>();
    private final Map<String, Location> before = new LinkedHashMap<>();
    private final Map<String, String> painted = new TreeMap<>();
    private final Map<String, Integer> refused = new TreeMap<>();
    private final Map<String, Integer> events = new TreeMap<>();
    private double timeBefore;
    private double fastest;
    private double lastPainted = Double.NEGATIVE_INFINITY;
    private int perceptions;
    private int accepted;

    private Painter(AgentClient agent, double seconds) {
        this.agent = agent;
        this.seconds = seconds;
    }

    /**
     * Runs the agent; exit code 1 if it could not join or was disconnected, 2 for wrong arguments.
     */
    public static void main(String[] arguments) {
        Map<String, String> options =
                new LinkedHashMap<>(
                        Map.of(
                                "--host",
                                "127.0.0.1",
                                "--port",
                                "7777",
                                "--name",
                                "painter",
                                "--seconds",
                                "5"));
        for (int i = 0; i < arguments.length; i += 2) {
            if (!options.containsKey(arguments[i]) || i + 1 == arguments.length) {
                System.err.println(USAGE);
                System.exit(arguments[i].equals("--help") ? 0 : 2);
            }
            options.put(arguments[i], arguments[i + 1]);
        }
        System.exit(run(options));
    }

    private static int run(Map<String, String> options) {
        try (AgentClient agent =
                AgentClient.connect(
                        options.get("--host"),
                        Integer.parseInt(options.get("--port")),
                        options.get("--name"))) {
            return new Painter(agent, Double.parseDouble(options.get("--seconds"))).run();
        } catch (NumberFormatException e) {
            System.err.println("painter: not a number: " + e.getMessage() + "\n" + USAGE);
            return 2;
        } catch (IOException | AgentException e) {
            System.err.println(
                    "painter: cannot paint at "
                            + options.get("--host")
                            + ":"
                            + options.get("--port")
                            + ": "
                            + e.getMessage());
            return 1;
        }
    }

    private int run() {
        summary.put("agent", agent.welcome().agent());
        summary.put("world", agent.welcome().world());
        String ended = "done";
        try {
            watch();
        } catch (DisconnectedException e) {
            ended = e.code();
        }
        countEvents();
        summary.put("perceptions", perceptions);
        summary.put("fastestMetresPerSecond", fastest);
        summary.put("painted", painted);
        summary.put("actsAccepted", accepted);
        summary.put("actsRefused", refused);
        summary.put("events", events);
        summary.put("ended", ended);
        System.out.println(new JsonMapper().writeValueAsString(summary));
        return ended.equals("done") || ended.equals("closing") ? 0 : 1;
    }

    private void watch() {
        agent.perceiveEvery(PERCEIVE_EVERY_FRAMES);
        Perception perception = agent.nextPerception();
        double begun = perception.time();
        summary.put("firstFrame", perception.frame());
        summary.put("items", perception.items().size());
        while (true) {
            perceptions++;
            summary.put("lastFrame", perception.frame());
            look(perception);
            if (perception.time() - begun >= seconds) {
                return;
            }
            perception = agent.nextPerception();
        }
    }

    private void look(Perception perception) {
        double passed = perception.time() - timeBefore;
        boolean paint = !before.isEmpty() && perception.time() - lastPainted >= PAINT_EVERY_SECONDS;
        for (Item item : perception.items()) {
            Location location = item.location().orElse(null);
            Location previous = location == null ? null : before.put(item.name(), location);
            if (previous != null) {
                double speed = distance(location, previous) / passed;
                fastest = Math.max(fastest, speed);
                if (paint && item.actions().getOrDefault("paint", Map.of()).containsKey("colour")) {
                    paint(item.name(), speed);
                }
            }
        }
        lastPainted = paint ? perception.time() : lastPainted;
        timeBefore = perception.time();
        countEvents();
    }

    private void paint(String item, double speed) {
        long red = Math.round(255 * (fastest > 0 ? speed / fastest : 0));
        String colour = String.format("#%02x40%02x", red, 255 - red);
        if (colour.equals(painted.get(item))) {
            return;
        }
        ActResult result = agent.act(item, "paint", Map.of("colour", colour));
        if (result.accepted()) {
            accepted++;
            painted.put(item, colour);
        } else {
            refused.merge(result.code().orElseThrow(), 1, Integer::sum);
        }
    }

    private void countEvents() {
        for (WorldEvent event : agent.events()) {
            events.merge(event.type(), 1, Integer::sum);
        }
    }

    private static double distance(Location a, Location b) {
        return Math.hypot(Math.hypot(a.x() - b.x(), a.y() - b.y()), a.z() - b.z());
    }
}
