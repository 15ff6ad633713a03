// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import reve.core.file.Problem;
import reve.core.file.WorldDescription;
import reve.pe.PhysicsLaw;

import java.util.ArrayList;
import java.util.List;
import java.util.Set;

/**
 * The check of a world and its loaded laws before the first frame. A warning names the place in the
 * file, the reason and a remedy. The checks judge laws by the properties that they declare, never
 * by their names. Only remedies contain names of laws.
 */
public final class WorldCheck {
    private WorldCheck() {}

    /**
     * Returns the warnings of the file and of all checks, in the order of their lines.
     *
     * @param laws the loaded laws of the world
     * @param texts ids of the libraries that are laws as text
     * @param shipped names of the law libraries that ship
     * @param complete whether all laws of the world are loaded; otherwise some checks are skipped,
     *     see {@link #leftOut}
     */
    public static List<Problem> warnings(
            WorldDescription world,
            List<PhysicsLaw> laws,
            Set<Integer> texts,
            Set<String> shipped,
            boolean complete) {
        Findings findings = new Findings(world);
        LawFacts facts = new LawFacts(world, laws, texts, shipped);
        ItemFacts items = new ItemFacts(world);
        new RowChecks(world, facts, items, findings).run(complete);
        new JointChecks(world, facts, items, findings).run(complete);
        new StepChecks(world, facts, items, findings).run();
        new MotionChecks(world, facts, items, findings).run(complete);
        new VoiceChecks(world, items, findings).run();
        if (complete) {
            new ContactChecks(world, facts, items, findings).run();
            new BallChecks(world, facts, items, findings).run();
        }
        List<Problem> all = new ArrayList<>(world.warnings());
        all.addAll(findings.all());
        return all.stream().distinct().sorted().toList();
    }

    /**
     * Returns a text that lists the checks that are skipped while some laws of a world are not
     * loaded.
     */
    public static String leftOut() {
        return "not checked without all laws: whether bodies are moved, turned and kept from"
                + " falling through each other, and whether a law reads each value";
    }
}
