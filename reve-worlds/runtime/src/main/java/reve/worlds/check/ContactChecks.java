// SPDX-License-Identifier: Apache-2.0
package reve.worlds.check;

import reve.core.file.WorldDescription;
import reve.core.text.Rounded;
import reve.core.world.Instrument;
import reve.core.world.ItemDefinition;
import reve.core.world.Mesh;
import reve.core.world.Shape;
import reve.core.world.WorldPrototype;
import reve.pe.PhysicsLaw;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.Comparator;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;

/** The checks for bodies that fall through an item or a floor below them. */
final class ContactChecks {
    /**
     * Height of a law's floor below which the floor counts as unused [m], because no body reaches
     * it.
     */
    private static final double LOWEST_FLOOR = -1e8;

    private static final double ROUNDING = 1e-6;

    /** Alpha of a colour that cannot be seen through. */
    private static final int OPAQUE = 255;

    /**
     * Distance of a hull's centre from the origin above which a warning is given, as a fraction of
     * the hull's extent.
     */
    private static final double OFF_CENTRE = 0.1;

    private static final String CONTACT_FORCE = WorldPrototype.CONTACT_FORCE;
    private static final String REACTION_FORCE = WorldPrototype.REACTION_FORCE;

    private final WorldDescription world;
    private final LawFacts laws;
    private final ItemFacts items;
    private final Findings findings;
    private final List<PhysicsLaw> balls;
    private final boolean surfaces;
    private final boolean shapes;

    ContactChecks(WorldDescription world, LawFacts laws, ItemFacts items, Findings findings) {
        this.world = world;
        this.laws = laws;
        this.items = items;
        this.findings = findings;
        balls = laws.all().stream().filter(laws::touchesBalls).toList();
        surfaces =
                laws.all().stream().anyMatch(laws::touchesSurfaces)
                        && items.mayExist(LawFacts.SURFACE);
        shapes = laws.all().stream().anyMatch(laws::touchesShapes);
    }

    void run() {
        checkForceSensors();
        if (laws.isUsed(LawFacts.MESH)) {
            checkHulls();
        }
        if (laws.mover().isPresent() && !surfaces && laws.all().stream().noneMatch(laws::mayHold)) {
            down().ifPresent(this::checkFloors);
        }
    }

    /** Warns of sensors of contact forces if no law of the world computes contact forces. */
    private void checkForceSensors() {
        boolean computed =
                laws.all().stream()
                        .anyMatch(
                                law ->
                                        laws.uses(law, WorldPrototype.BODY, CONTACT_FORCE)
                                                || laws.uses(
                                                        law, WorldPrototype.BODY, REACTION_FORCE));
        if (computed) {
            return;
        }
        findings.items(
                items.all().stream().filter(ContactChecks::hasForceSensor).toList(),
                "sensors",
                body ->
                        "sensors: the contact force on "
                                + body.name()
                                + " is always 0, because no law of this world computes it; add a"
                                + " law that does, for example rigid_contact");
    }

    private static boolean hasForceSensor(ItemFacts.Entry entry) {
        return entry.item().sensors().stream()
                .anyMatch(
                        sensor ->
                                sensor.instrument().orElse(null)
                                        instanceof Instrument.ContactForce);
    }

    /**
     * Warns of bodies whose mesh has no convex hull, or a hull that is not centred at the body's
     * centre of mass.
     */
    private void checkHulls() {
        List<ItemFacts.Entry> bodies =
                items.movable().stream()
                        .filter(body -> body.item().shape() instanceof Mesh)
                        .toList();
        findings.items(
                bodies.stream().filter(body -> mesh(body).hull().isEmpty()).toList(),
                "physical.shape",
                body ->
                        "shape: nothing touches "
                                + body.name()
                                + ", because "
                                + reason(mesh(body))
                                + "; a body that moves touches others with the convex hull of its"
                                + " mesh, so give the mesh a volume, or use a thin box");
        findings.items(
                bodies.stream().filter(ContactChecks::isOffCentre).toList(),
                "physical.shape",
                body ->
                        "shape: the centre of the convex hull of "
                                + body.name()
                                + " is at "
                                + centre(mesh(body))
                                + " m, but laws turn a body about its origin, as its centre of"
                                + " mass; move the vertices by the opposite of that");
    }

    private static Mesh mesh(ItemFacts.Entry body) {
        return (Mesh) body.item().shape();
    }

    private static String reason(Mesh mesh) {
        try {
            mesh.requireHull();
            return "";
        } catch (IllegalArgumentException refused) {
            return refused.getMessage();
        }
    }

    /**
     * Returns whether the hull of a body's mesh has its centre far from the body's centre of mass.
     * A mesh with a density was already checked when the density was read.
     */
    private static boolean isOffCentre(ItemFacts.Entry body) {
        Mesh mesh = mesh(body);
        double extent = Math.max(mesh.size(0), Math.max(mesh.size(1), mesh.size(2)));
        return mesh.hull()
                .filter(
                        hull ->
                                Arrays.stream(hull.centre())
                                        .anyMatch(at -> Math.abs(at) > OFF_CENTRE * extent))
                .isPresent();
    }

    private static String centre(Mesh mesh) {
        double[] at = mesh.hull().orElseThrow().centre();
        return String.format(Locale.ROOT, "(%.3g %.3g %.3g)", at[0], at[1], at[2]);
    }

    /** Returns the axis and the direction of gravity, if gravity acts along an axis. */
    private Optional<Down> down() {
        List<Double> gravity = world.constants().get(LawFacts.GRAVITY);
        if (gravity == null || !laws.isRead(WorldPrototype.WORLD, LawFacts.GRAVITY)) {
            return Optional.empty();
        }
        int axis = 0;
        for (int other = 1; other < 3; other++) {
            if (Math.abs(gravity.get(other)) > Math.abs(gravity.get(axis))) {
                axis = other;
            }
        }
        return gravity.get(axis) == 0
                ? Optional.empty()
                : Optional.of(
                        new Down(
                                axis, Math.signum(gravity.get(axis)), Math.abs(gravity.get(axis))));
    }

    /**
     * The direction of gravity.
     *
     * @param sign of the component along the axis
     * @param size magnitude of the component along the axis [m/s^2]
     */
    private record Down(int axis, double sign, double size) {}

    private void checkFloors(Down down) {
        List<Floor> floors = floors();
        Map<Fault, List<ItemFacts.Entry>> found = new LinkedHashMap<>();
        Map<Fault, Floor> below = new LinkedHashMap<>();
        Optional<Floor> level = level(down);
        for (ItemFacts.Entry body : items.movable()) {
            if (body.has("appliedForce")
                    || items.isReferredTo(body)
                    || body.item().shape() == Shape.none() && (!shapes || items.isCarrier(body))) {
                continue;
            }
            List<Floor> reached =
                    floors.stream()
                            .filter(floor -> isBelow(floor, body, down))
                            .sorted(
                                    Comparator.comparingDouble(
                                            floor -> floor.top(down) * down.sign))
                            .toList();
            Optional<Floor> passed =
                    reached.stream().noneMatch(floor -> holds(floor, body))
                            ? reached.stream().findFirst().or(() -> missed(level, body, down))
                            : reached.stream()
                                    .filter(Floor::solid)
                                    .filter(floor -> landsOn(floor, body, down))
                                    .findFirst()
                                    .filter(floor -> !stops(floor, body, down));
            passed.ifPresent(
                    floor -> {
                        Fault fault = fault(body);
                        found.computeIfAbsent(fault, _ -> new ArrayList<>()).add(body);
                        below.putIfAbsent(fault, floor);
                    });
        }
        found.forEach((fault, bodies) -> report(fault, bodies, below.get(fault), down));
    }

    /** The reasons why a body falls through a floor. */
    private enum Fault {
        NO_LAW,
        NO_RADIUS,
        NO_FLOOR,
        NO_SHAPE,
        SCENERY
    }

    private Fault fault(ItemFacts.Entry body) {
        if (shapes) {
            return body.item().shape() == Shape.none() ? Fault.NO_SHAPE : Fault.SCENERY;
        }
        return balls.isEmpty()
                ? Fault.NO_LAW
                : body.has(LawFacts.RADIUS) ? Fault.NO_FLOOR : Fault.NO_RADIUS;
    }

    private void report(Fault fault, List<ItemFacts.Entry> bodies, Floor floor, Down down) {
        switch (fault) {
            case NO_LAW ->
                    findings.items(
                            bodies,
                            "physical.shape",
                            body ->
                                    body.name()
                                            + " falls through "
                                            + floor.name
                                            + ", because no law of this world makes bodies touch; "
                                            + remedy(body, floor, down));
            case NO_RADIUS -> {
                List<ItemFacts.Entry> others =
                        bodies.stream().filter(body -> !BallChecks.isDrawnBall(body)).toList();
                findings.items(
                        others,
                        "physical.shape",
                        body ->
                                body.name()
                                        + " falls through "
                                        + floor.name
                                        + ", because "
                                        + balls.getFirst().name()
                                        + " knows bodies as balls only, and `physics.radius` of "
                                        + body.name()
                                        + " is not set; set it, or "
                                        + remedy(body, floor, down));
            }
            case NO_FLOOR ->
                    findings.items(
                            bodies,
                            "physical.shape",
                            body ->
                                    body.name()
                                            + " falls through "
                                            + floor.name
                                            + ", because "
                                            + balls.getFirst().name()
                                            + " does not know "
                                            + floor.name
                                            + "; "
                                            + floorRemedy(balls.getFirst(), floor, down));
            case NO_SHAPE ->
                    findings.items(
                            bodies,
                            "physics.mass",
                            body ->
                                    body.name()
                                            + " falls through "
                                            + floor.name
                                            + ", because a body without a shape touches nothing;"
                                            + " set `shape` under `physical`");
            case SCENERY ->
                    findings.items(
                            bodies,
                            "physical.shape",
                            body ->
                                    body.name()
                                            + " falls through "
                                            + floor.name
                                            + ", because "
                                            + floor.name
                                            + " has no `physics`, so no law knows it; give it"
                                            + " physics: {mass: 0}");
        }
    }

    private String floorRemedy(PhysicsLaw law, Floor floor, Down down) {
        Optional<Double> height = laws.parameter(law, LawFacts.FLOOR);
        boolean other = height.filter(at -> at > LOWEST_FLOOR).isPresent();
        Optional<String> advice = laws.rigidContact().filter(_ -> other || !floor.level);
        String rigid = advice.map(text -> text + ", or ").orElse("");
        if (height.isPresent() && floor.level && down.axis == 1 && down.sign < 0) {
            return rigid
                    + "set its parameter "
                    + LawFacts.FLOOR
                    + ": "
                    + Rounded.of(floor.top(down))
                    + " m"
                    + (other ? " if the world has no other floor" : "");
        }
        return rigid
                + "build "
                + floor.name
                + " from immovable balls, or from items of kind surface with surface_contact";
    }

    /**
     * Returns the remedy at the end of a message: the shipped laws that would keep a body from
     * falling through a floor.
     */
    private String remedy(ItemFacts.Entry body, Floor floor, Down down) {
        if (laws.rigidContact().isPresent()) {
            return laws.rigidContact().get()
                    + (floor.drawn ? "" : ", with an item with a shape as the floor");
        }
        return body.item().shape() instanceof Shape.Sphere && down.axis == 1
                ? "add sphere_contact to `laws` with its parameter floorHeight: "
                        + Rounded.of(floor.top(down))
                        + " m, and set `physics.radius` of "
                        + body.name()
                : "add surface_contact to `laws`, and build "
                        + floor.name
                        + " from items of kind surface with a hardness";
    }

    /**
     * The bounding box of an item that has a shape and is moved by no law.
     *
     * @param drawn false for the floor of a law, which is no item
     * @param level whether the shape has the same height everywhere
     * @param solid whether the shape fills its box and cannot be seen through
     */
    private record Floor(
            String name,
            boolean physics,
            double radius,
            boolean drawn,
            boolean level,
            boolean solid,
            double[] low,
            double[] high) {
        double top(Down down) {
            return down.sign < 0 ? high[down.axis] : low[down.axis];
        }
    }

    private List<Floor> floors() {
        List<Floor> floors = new ArrayList<>();
        for (ItemFacts.Entry entry : items.all()) {
            ItemDefinition item = entry.item();
            if (entry.isBody()
                    && !entry.isMovable()
                    && item.parent().isEmpty()
                    && item.shape() != Shape.none()
                    && !items.isSetByActions("mass")) {
                floors.add(floor(entry));
            }
        }
        return floors;
    }

    private static Floor floor(ItemFacts.Entry entry) {
        ItemDefinition item = entry.item();
        double[] at = item.location();
        double[] half = extents(item);
        double[] low = new double[3];
        double[] high = new double[3];
        for (int axis = 0; axis < 3; axis++) {
            low[axis] = at[axis] - half[axis];
            high[axis] = at[axis] + half[axis];
        }
        boolean flat = item.shape() instanceof Shape.Box || item.shape() instanceof Shape.Plane;
        return new Floor(
                entry.name(),
                item.hasPhysics(),
                entry.number(LawFacts.RADIUS),
                true,
                flat && isUpright(item),
                flat && item.colour().rgba() >>> 24 == OPAQUE,
                low,
                high);
    }

    /** Returns whether the y axis of an item is vertical. */
    private static boolean isUpright(ItemDefinition item) {
        double[] q = item.orientation();
        return q[0] * q[0] + q[2] * q[2] < ROUNDING;
    }

    /** Returns the floor that a law of contacts between balls has at a height. */
    private Optional<Floor> level(Down down) {
        if (down.axis != 1 || down.sign > 0 || shapes || items.isSetByActions(LawFacts.RADIUS)) {
            return Optional.empty();
        }
        return balls.stream()
                .map(law -> laws.parameter(law, LawFacts.FLOOR).orElse(LOWEST_FLOOR))
                .filter(height -> height > LOWEST_FLOOR)
                .findFirst()
                .map(ContactChecks::level);
    }

    private static Floor level(double height) {
        double far = Double.POSITIVE_INFINITY;
        return new Floor(
                "the floor at the height " + Rounded.of(height) + " m",
                true,
                0,
                false,
                true,
                true,
                new double[] {-far, height, -far},
                new double[] {far, height, far});
    }

    /** Returns the floor of a law that a body misses because the body has no radius. */
    private Optional<Floor> missed(Optional<Floor> level, ItemFacts.Entry body, Down down) {
        return level.filter(_ -> !body.has(LawFacts.RADIUS) && !BallChecks.isDrawnBall(body))
                .filter(floor -> isBelow(floor, body, down));
    }

    /** Returns the half extents of an item's shape along the axes of the world [m]. */
    private static double[] extents(ItemDefinition item) {
        double[] q = item.orientation();
        double x = q[0];
        double y = q[1];
        double z = q[2];
        double w = q[3];
        double[][] rotation = {
            {1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
            {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
            {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}
        };
        double[] half = new double[3];
        for (int axis = 0; axis < 3; axis++) {
            for (int own = 0; own < 3; own++) {
                half[axis] += Math.abs(rotation[axis][own]) * item.shape().size(own) / 2;
            }
        }
        return half;
    }

    private static boolean isBelow(Floor floor, ItemFacts.Entry body, Down down) {
        double[] at = body.item().location();
        double[] half = extents(body.item());
        for (int axis = 0; axis < 3; axis++) {
            if (axis != down.axis
                    && !(at[axis] >= floor.low[axis] && at[axis] <= floor.high[axis])) {
                return false;
            }
        }
        double bottom = at[down.axis] + down.sign * half[down.axis];
        return (floor.top(down) - bottom) * down.sign >= -ROUNDING - 2 * half[down.axis];
    }

    /** Returns whether a law of this world keeps this body from falling through this floor. */
    private boolean holds(Floor floor, ItemFacts.Entry body) {
        if (shapes
                && body.item().shape() != Shape.none()
                && (floor.physics || laws.isUsed(LawFacts.SCENERY))) {
            return true;
        }
        return body.has(LawFacts.RADIUS)
                && balls.stream()
                        .anyMatch(
                                law ->
                                        floor.physics && floor.radius > 0
                                                || laws.parameter(law, LawFacts.FLOOR)
                                                                .orElse(LOWEST_FLOOR)
                                                        > LOWEST_FLOOR);
    }

    /**
     * Returns whether a body starts above a floor and falls onto it, if only gravity acts on the
     * body.
     */
    private static boolean landsOn(Floor floor, ItemFacts.Entry body, Down down) {
        double[] at = body.item().location();
        double half = extents(body.item())[down.axis];
        double height = (floor.top(down) - at[down.axis]) * down.sign - half;
        if (height < -half / 2) {
            return false;
        }
        double[] v = body.item().physics(LawFacts.VELOCITY).orElse(new double[3]);
        double speed = v[down.axis] * down.sign;
        double seconds =
                (Math.sqrt(speed * speed + 2 * down.size * Math.max(height, 0)) - speed)
                        / down.size;
        for (int axis = 0; axis < 3; axis++) {
            double place = at[axis] + v[axis] * seconds;
            if (axis != down.axis && !(place >= floor.low[axis] && place <= floor.high[axis])) {
                return false;
            }
        }
        return true;
    }

    /**
     * Returns whether a law of this world stops a body near the top of this floor. A body that
     * sinks by less than its radius counts as stopped.
     */
    private boolean stops(Floor floor, ItemFacts.Entry body, Down down) {
        if (shapes || !body.has(LawFacts.RADIUS) || floor.physics && floor.radius > 0) {
            return true;
        }
        return balls.stream()
                .map(law -> laws.parameter(law, LawFacts.FLOOR).orElse(LOWEST_FLOOR))
                .anyMatch(height -> height >= floor.top(down) - body.number(LawFacts.RADIUS));
    }
}
