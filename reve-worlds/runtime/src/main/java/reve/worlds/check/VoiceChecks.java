// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import reve.core.file.AgentPolicy;
import reve.core.file.WorldDescription;
import reve.core.world.ItemDefinition;
import reve.core.world.Sensor;

import java.util.List;
import java.util.Optional;

/**
 * The checks for voices that no agent can use or hear, and for ears that hear nothing. Only bodies
 * that agents can have speak and hear. An agent whose body has no sensors perceives everything, and
 * therefore hears all voices.
 */
final class VoiceChecks {
    private static final String VOICE = "voice";
    private static final String SENSORS = "sensors";

    private final WorldDescription world;
    private final ItemFacts items;
    private final Findings findings;
    private final List<ItemFacts.Entry> bodies;
    private final Optional<ItemDefinition> template;

    /** Maximum number of agents at a time whose bodies are created from the template. */
    private final long created;

    VoiceChecks(WorldDescription world, ItemFacts items, Findings findings) {
        AgentPolicy agents = world.agents();
        this.world = world;
        this.items = items;
        this.findings = findings;
        this.bodies = agents.bodies().stream().map(items::find).flatMap(Optional::stream).toList();
        this.template = agents.template();
        long places = agents.places().isEmpty() ? Long.MAX_VALUE : agents.places().size();
        this.created =
                template.isEmpty() ? 0 : Math.min(places, agents.most() - (long) bodies.size());
    }

    void run() {
        long speakers = count(VoiceChecks::speaks);
        long hearers = count(VoiceChecks::hears);
        checkUnused();
        findings.items(
                bodies.stream()
                        .filter(body -> speaks(body.item()))
                        .filter(body -> hearers - (hears(body.item()) ? 1 : 0) == 0)
                        .toList(),
                VOICE,
                body -> unheard(body.name()));
        template.filter(body -> created > 0 && speaks(body))
                .filter(body -> hearers - (hears(body) ? 1 : 0) == 0)
                .ifPresent(_ -> findings.template(VOICE, unheard("the body of an agent")));
        findings.items(
                bodies.stream()
                        .filter(body -> hasEars(body.item()))
                        .filter(body -> speakers - (speaks(body.item()) ? 1 : 0) == 0)
                        .toList(),
                SENSORS,
                body -> deaf(body.name()));
        template.filter(body -> created > 0 && hasEars(body))
                .filter(body -> speakers - (speaks(body) ? 1 : 0) == 0)
                .ifPresent(_ -> findings.template(SENSORS, deaf("the body of an agent")));
    }

    /** A property of a body that agents can have. */
    private interface Condition {
        boolean holds(ItemDefinition body);
    }

    /** Returns the number of agents at a time whose bodies meet a condition. */
    private long count(Condition condition) {
        return bodies.stream().filter(body -> condition.holds(body.item())).count()
                + (template.filter(condition::holds).isPresent() ? created : 0);
    }

    private static boolean speaks(ItemDefinition body) {
        return body.voice().isPresent();
    }

    private static boolean hears(ItemDefinition body) {
        return body.sensors().isEmpty() || hasEars(body);
    }

    private static boolean hasEars(ItemDefinition body) {
        return body.sensors().stream().anyMatch(Sensor::hearing);
    }

    /** Warns of voices of items that no agent can have as its body. */
    private void checkUnused() {
        List<String> names = world.agents().bodies();
        findings.items(
                items.all().stream()
                        .filter(item -> speaks(item.item()))
                        .filter(item -> !names.contains(item.name()))
                        .toList(),
                VOICE,
                item ->
                        "voice: "
                                + item.name()
                                + " never speaks, because no agent can have it as its body; add "
                                + item.name()
                                + " to `bodies` under `agents`");
    }

    private static String unheard(String name) {
        return "voice: no agent hears "
                + name
                + ", because no other body that agents can have hears voices; give one of them a"
                + " sensor such as ears: {hearing: true}";
    }

    private static String deaf(String name) {
        return "sensors: "
                + name
                + " hears nothing, because no other body that agents can have has a voice; give one"
                + " of them a `voice`";
    }
}
