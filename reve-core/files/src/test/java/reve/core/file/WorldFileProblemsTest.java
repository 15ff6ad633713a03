// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;
import org.junit.jupiter.params.provider.ValueSource;

import java.nio.charset.StandardCharsets;
import java.util.List;

/** The messages about faulty world files, and their places. */
class WorldFileProblemsTest {
    private static WorldFileException refused(String yaml) {
        return catchThrowableOfType(
                WorldFileException.class,
                () -> WorldFile.parse("w", yaml.getBytes(StandardCharsets.UTF_8)));
    }

    private static List<String> problems(String yaml) {
        WorldFileException refused = refused(yaml);
        assertThat(refused).as("refusal of\n%s", yaml).isNotNull();
        return refused.problems().stream().map(Problem::toString).toList();
    }

    /** Appends a line to a small valid world, so that it is line 6. */
    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '!',
            quoteCharacter = '\'',
            textBlock =
                    """
                    prototyp: si-f64                      ! 1  ! unknown key `prototyp`; did you mean `prototype`?
                    colour: red                           ! 1  ! unknown key `colour`; known here: reve, name, doc, include, prototype, properties, frame, laws, constants, camera, cameras, agents, substances, prefabs, classes, symbols, rules, items, forces
                    prototype: si-f46                     ! 12 ! prototype: found text `si-f46`, expected one of `si-f64`, `si-f32`; did you mean `si-f64`?
                    frame: {rate: 60.5}                   ! 15 ! rate: found number 60.5, expected a whole number
                    frame: {rate: 0}                      ! 15 ! rate: found number 0, expected at least 1
                    frame: {steps: 10001}                 ! 16 ! steps: found number 10001, expected at most 10000
                    frame: {rate: 99999999999999999999}   ! 15 ! rate: found number 1.0E20, expected at most 10000
                    frame: {steps: -5e23}                 ! 16 ! steps: found number -5.0E23, expected at least 1
                    frame: 60                             ! 8  ! frame: found number 60, expected a mapping
                    frame:                                ! 7  ! frame: found nothing, expected a mapping
                    doc: 3                                ! 6  ! doc: found number 3, expected a text; put it in quotes
                    laws: hooke                           ! 7  ! laws: found text `hooke`, expected a list
                    laws: [a, b, a]                       ! 14 ! duplicate law `a`, first on line 6
                    laws: [{parameters: {}}]              ! 8  ! laws[0]: found neither, expected one of `name` and `text`
                    laws: [{name: a, parameters: {x: [1]}}]! 34 ! x: found 1 number, expected 3 numbers
                    laws: [{name: a, parameters: {x: 3 q}}]! 34 ! x: unit `q`: `q` is not a unit that is known here
                    laws: [{name: a, parameters: {x: 1 2}}]! 34 ! x: found 2 numbers, expected one, or the three of a vector
                    laws: [{name: a, budget: 3 kg}]       ! 26 ! budget: unit kg does not fit s
                    laws: [{name: a, budget: 0 s}]        ! 26 ! budget: found 0.0 s, expected a time above 0 s, and at most 10 s
                    laws: [{name: a, budget: {frames: 3}}]! 26 ! budget: `time` is missing
                    laws: [{name: a, budget: {time: 1 ms, then: stop}}]! 45 ! then: found text `stop`, expected one of `warn`, `unload`, `skip-steps`
                    laws: [{name: a, budget: {time: 1 ms, every: 1}}]! 46 ! every: found number 1, expected at least 2
                    laws: [' ']                           ! 8  ! laws[0]: found text ` `, expected the name of a law: letters, digits, `_` and `-`, never a path; or `text`, a law as text
                    laws: [./evil.so]                     ! 8  ! laws[0]: found text `./evil.so`, expected the name of a law: letters, digits, `_` and `-`, never a path; or `text`, a law as text
                    laws: [{name: ../x/libvesper_law_y.so}] ! 15 ! name: found text `../x/libvesper_law_y.so`, expected the name of a law: letters, digits, `_` and `-`, never a path
                    constants: {gravity: 3}               ! 22 ! gravity: found 1 number, expected 3 numbers in m/s^2
                    constants: {gravty: 3}                ! 13 ! unknown physics property `gravty` of kind world; did you mean `gravity`?
                    constants: {softening: -2 cm}         ! 24 ! softening: found -0.02, expected 0 or more [m]
                    properties: [{name: a, kind: body, min: low}] ! 41 ! min: found text `low`, expected a number
                    constants: {softening: yes}           ! 24 ! softening: found text `yes`, expected a number in m
                    constants: {softening: true}          ! 24 ! softening: found `true`, expected a number, a text or a list
                    constants: {softening: .nan}          ! 24 ! softening: `.nan` is not a finite number
                    constants: {softening: -.INF}         ! 24 ! softening: `-.INF` is not a finite number
                    constants: {softening: NaN}           ! 24 ! softening: `NaN` is not a finite number
                    constants: {softening: 1e999}         ! 24 ! softening: `1e999` is too large for a 64-bit number
                    constants: {softening: 1e999 m}       ! 24 ! softening: `1e999` is too large for a 64-bit number
                    constants: {softening: 1e308 km}      ! 24 ! softening: 1.0E308 km is too large for a 64-bit number
                    constants: {softening: 3m}            ! 24 ! softening: `3m` needs a space between number and unit: `3 m`
                    constants: {softening: 3 °C}          ! 24 ! softening: unit `°C`: it is not a plain multiple of SI units (for temperatures use K)
                    constants: {softening: m 3}           ! 24 ! softening: found text `m 3`, expected a number in m
                    constants: {softening: ''}            ! 24 ! softening: found text ``, expected a number in m
                    constants: {gravity: [1, 2 m, 3]}     ! 26 ! gravity: found text `2 m` in a list of numbers; a unit goes behind all of them, as in `0 0 0 m/s^2`
                    camera: {eye: [0, 0, 0]}              ! 9  ! camera: `target` is missing
                    camera: {eye: [0, 0, 0], target: [0, 0, 0]} ! 34 ! target: is where the eye is
                    camera: {eye: [0, 0, 0], target: [0, 9, 0]} ! 34 ! up: has no direction across the line of sight, expected another `up`
                    camera: {eye: [0, 0, 0], target: [1, 0, 0], fov: 45} ! 50 ! fov: 45.0 rad is not between 0.1 and 175 deg; write degrees as `45 deg`
                    cameras: {a: {eye: [0, 0, 1]}}        ! 14 ! a: `target` is missing
                    cameras: {a: {target: [0, 0, 1]}}     ! 14 ! a: `eye` is missing
                    cameras: {a: {eye: [0, 0, 1], lookAt: moon}} ! 39 ! lookAt: no item is named `moon`
                    cameras: {a: {eye: [0, 0, 1], target: [1, 1, 1], turning: true}} ! 59 ! turning: the camera follows no item, expected `follow` beside it
                    cameras: {a: {target: [0, 0, 0], keyframes: [{time: 2, eye: [0, 0, 1]}, {time: 2, eye: [0, 0, 2]}]}} ! 80 ! time: 2.0 s is not after the keyframe before it, at 2.0 s
                    forces: [{item: on, force: [0, 1, 0], frames: 1}] ! 17 ! item: no item is named `on`; did you mean `one`?
                    forces: [{item: one, force: [0, 1, 0], frames: 0}] ! 48 ! frames: found number 0, expected at least 1
                    forces: [{item: one, force: 3 kg, frames: 1}] ! 29 ! force: unit kg does not fit N
                    forces: [{item: one, frames: 1}]      ! 10 ! forces[0]: `force` is missing
                    agents: {}                            ! 9  ! agents: found a mapping, expected at least 1 in it
                    agents: {bodies: [on]}                ! 19 ! bodies[0]: no item is named `on`; did you mean `one`?
                    agents: {bodies: [one, one]}          ! 24 ! bodies[1]: `one` is listed twice
                    agents: {body: {name: x}}             ! 17 ! unknown key `name`; known here: like, physical, semantic, access, capabilities, physics, sensors, voice
                    classes: {cup: vesel, vessel: body}   ! 16 ! cup: there is no class or kind `vesel`; did you mean `vessel`?
                    classes: {cup: {is: bodi}}            ! 21 ! is: there is no class or kind `bodi`; did you mean `body`?
                    classes: {cup: world}                 ! 16 ! cup: there is only one world, which has no class
                    classes: {body: {}}                   ! 11 ! `body` is a kind; expected another name of a class
                    classes: {a: b, b: {is: c}, c: a}     ! 14 ! a: classes are above each other in a circle: a, b, c, a
                    classes: {a: a}                       ! 14 ! a: classes are above each other in a circle: a, a
                    classes: {9a: {}}                     ! 11 ! `9a` is not a name; expected a letter, then letters, digits, spaces, - or _, at most 64 in all
                    classes: {a: {like: x}}               ! 15 ! unknown key `like`; known here: is, doc, semantic, physics
                    classes: {a: {semantic: {class: b}}}  ! 26 ! class a: symbol class is a standard one; a class cannot give it
                    classes: {a: {semantic: {on: b}}}     ! 26 ! class a: symbol on is a standard one; a class cannot give it
                    classes: {a: {physics: {masss: 1}}}   ! 25 ! unknown physics property `masss` of kind body; did you mean `mass`?
                    classes: {a: {is: spring, physics: {mass: 1}}} ! 37 ! unknown physics property `mass` of kind spring; it is a property of kind body
                    classes: {a: {physics: {mass: -1}}}   ! 31 ! mass: found -1.0, expected 0 or more [kg]
                    classes: {a: {physics: {mass: 1, density: 2}}} ! 34 ! density: `mass` is given too, which follows from density and shape; say one of them
                    classes: {a: {physics: {density: 0}}} ! 34 ! density: 0.0, expected a positive one
                    classes: {a: {is: spring, physics: {end1: one}}} ! 37 ! end1: refers to items, which a class cannot give to its items
                    properties: [{name: mass, kind: body}]! 21 ! property mass of kind body: the name is already taken by a property of kind body
                    properties: [{name: position, kind: lamp}] ! 21 ! property position of kind body: the name is already taken by a property of kind lamp
                    properties: [{name: 9a, kind: body}]  ! 21 ! name: found text `9a`, expected a letter, then letters, digits or _, at most 47 in all
                    properties: [{name: a, kind: body, unit: foo}] ! 42 ! unit `foo`: `foo` is not a unit that is known here
                    properties: [{name: a, kind: body, type: f64}] ! 42 ! type: found text `f64`, expected one of `real`, `i32`, `u32`, `field`
                    properties: [{name: a, kind: body, components: 17}] ! 48 ! components: found number 17, expected at most 16
                    name: again                           ! 1  ! duplicate key `name`, first on line 2
                    """)
    void refusesAtTheTopLevel(String line, int column, String message) {
        assertThat(problems("reve: 1\nname: w\nitems:\n- name: one\n  physics: {mass: 1}\n" + line))
                .containsExactly("w:6:" + column + ": " + message);
    }

    /** The content of an item besides its name, on line 5. */
    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '!',
            quoteCharacter = '\'',
            textBlock =
                    """
                    physcal: {}                                 ! 3  ! unknown key `physcal`; did you mean `physical`?
                    kind: sprung                                ! 9  ! kind: no properties are declared for kind `sprung`, known are body, spring, surface, world; did you mean `spring`?
                    kind: world                                 ! 9  ! kind: there is only one world; its properties belong under `constants`
                    physics: {masss: 1}                         ! 13 ! unknown physics property `masss` of kind body; did you mean `mass`?
                    physics: {springConstant: 1}                ! 13 ! unknown physics property `springConstant` of kind body; it is a property of kind spring
                    physics: {position: 1}                      ! 13 ! unknown physics property `position` of kind body; known are mass, charge, velocity, acceleration, externalForce, appliedForce, radius, angularVelocity, inertia, torque, dragCoefficient, linearDragCoefficient; others are declared under `properties`
                    physics: {velocity: 3 kg}                   ! 23 ! velocity: unit kg does not fit m/s
                    physics: {velocity: 0 3 0 kg}               ! 23 ! velocity: unit kg does not fit m/s
                    physics: {velocity: [0, 3]}                 ! 23 ! velocity: found 2 numbers, expected 3 numbers in m/s
                    physics: {mass: 1, mass: 2}                 ! 22 ! duplicate key `mass`, first on line 5
                    physics: {mass: {}}                         ! 19 ! mass: found a mapping, expected a number, a text or a list
                    physics: {mass: }                           ! 18 ! mass: found nothing, expected a number, a text or a list
                    physical: {shape: ball}                     ! 21 ! shape: found text `ball`, expected one of `sphere`, `box`, `plane`, `capsule`, `cylinder`, `ellipsoid`, `terrain`, `mesh`
                    physical: {shape: sphere}                   ! 21 ! shape sphere needs `radius`
                    physical: {radius: 1}                       ! 14 ! `radius` without a `shape`
                    physical: {shape: box, size: 3}             ! 32 ! size: found 1 number, expected 3 numbers in m
                    physical: {shape: sphere, radius: 0}         ! 37 ! radius of sphere is 0.0, expected a positive length of at most 1e12 m
                    physical: {shape: sphere, radius: 1, size: 2} ! 40 ! `size` does not go with shape sphere, which takes `radius`
                    physical: {colour: red}                     ! 22 ! colour: found text `red`, expected "#rrggbb" or "#rrggbbaa", in quotes
                    physical: {location: [1, 2, .inf]}          ! 31 ! `.inf` is not a finite number
                    physical: {orientation: [0, 0, 0, 0]}       ! 27 ! item one: orientation is the zero quaternion, expected a rotation such as 0 0 0 1
                    physical: {orientation: {axis: [0, 0, 0], angle: 1}} ! 34 ! axis: has no direction, expected one such as 0 1 0
                    physical: {orientation: {axis: [0, 1, 0]}}  ! 27 ! orientation: `angle` is missing
                    physical: {shape: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1]], triangles: [[0, 1, 2]]} ! 60 ! vertices[2]: found 2 numbers, expected 3 numbers in m
                    physical: {shape: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [[0, 1, 3]]} ! 84 ! triangles[0]: 3.0 is not the number of a vertex, expected 0 to 2
                    semantic: {name: x}                         ! 14 ! item one: name is a symbol that the world derives; it cannot be set
                    semantic: {a: {}}                           ! 17 ! a: found a mapping, expected a text, a number, true or false or a list
                    semantic: {a: [[1]]}                        ! 18 ! a[0]: found a list of 1, expected a text, a number or true or false
                    semantic: {'a b': 1}                        ! 14 ! `a b` is not a name; expected a letter, then letters, digits, - or _, at most 64 in all
                    capabilities: [grip, ' ']                   ! 24 ! capabilities[1]: found text ` `, expected a letter, then letters, digits, - or _, at most 64 in all
                    access: {push: {}}                          ! 12 ! an action has either `effects` or `java`
                    access: {push: {effects: []}}               ! 28 ! effects: found a list of 0, expected at least 1 in it
                    access: {push: {effects: [{}]}}             ! 29 ! effects[0]: an effect is exactly one of `impulse`, `force`, `set`, `symbol`, `attach`, `detach`, `create`, `remove`, `raise`, found 0
                    access: {push: {effects: [{set: physical.colour}]}} ! 35 ! `set` needs `to`, the new value
                    access: {push: {effects: [{raise: x, to: 3}]}}  ! 44 ! `to` does not go with `raise`
                    access: {push: {effects: [{impulse: [1, 2, 3]}]}} ! 30 ! the item has no `physics`, so this action could never work
                    access: {push: {effects: [{set: physics.mas, to: 1}]}} ! 35 ! unknown physics property `mas` of kind body; did you mean `mass`?
                    access: {push: {effects: [{set: color, to: x}]}} ! 35 ! set: found text `color`, expected physics.PROPERTY, physical.location, physical.orientation or physical.colour
                    access: {push: {effects: [{set: physical.colour, to: x}]}} ! 56 ! to: colour "x": expected #rrggbb or #rrggbbaa, for example #c0392b
                    access: {push: {effects: [{symbol: dimensions, to: x}]}} ! 38 ! symbol: dimensions is derived by the world and cannot be set
                    access: {push: {effects: [{symbol: a, to: {b: 1}}]}} ! 45 ! to: found a mapping, expected a number, a text, true or false or a list
                    access: {push: {effects: [{symbol: a, to: $x}]}} ! 45 ! to: the action has no parameter `x`
                    access: {push: {effects: [{symbol: a, to: 1}, {symbol: a, to: 2}]}} ! 12 ! action push has two effects that change semantic.a
                    access: {push: {parameters: {p: {type: text, unit: m}}, effects: [{symbol: a, to: $p}]}} ! 32 ! parameter p: only numbers have components, a unit and a range
                    access: {push: {java: no.such, effects: [{raise: a}]}} ! 12 ! an action has either `effects` or `java`
                    access: {push: {parameters: {p: {min: 2, max: 1}}, effects: [{raise: a}]}} ! 32 ! parameter p: no number is from 2.0 to 1.0
                    access: {push: {parameters: {physics: {}}, effects: [{raise: a}]}} ! 32 ! parameter physics: the name means something else in expressions; choose another
                    access: {push: {when: physics.masss > 1, effects: [{raise: a}]}} ! 32 ! when: unknown name `masss`; known here: acceleration, angularVelocity, appliedForce, charge, dragCoefficient, externalForce, inertia, linearDragCoefficient, mass, radius, torque, velocity
                    access: {push: {when: ['item.name +'], effects: [{raise: a}]}} ! 38 ! when[0]: the expression ends too early
                    access: {push: {when: physics.mass, effects: [{raise: a}]}} ! 25 ! when: `physics.mass` is a number, expected true or false
                    access: {push: {effects: [{remove: true, to: 1}]}} ! 48 ! `to` does not go with `remove`
                    access: {push: {effects: [{remove: false}]}} ! 38 ! remove: found `false`, expected true
                    access: {push: {effects: [{attach: wall}]}} ! 38 ! attach: found text `wall`, expected `item`, `actor` or the name of a parameter of type item
                    access: {push: {effects: [{detach: true}, {remove: true}]}} ! 12 ! action push has two effects that change what is attached or removed
                    access: {push: {effects: [{raise: a, with: {item: 1}}]}} ! 47 ! every event has the field item already
                    access: {push: {effects: [{create: {name: b}, with: {physics.mas: 1}}]}} ! 69 ! unknown physics property `mas` of kind body; did you mean `mass`?
                    access: {push: {effects: [{create: {name: b, like: c}}]}} ! 54 ! like: there is no prefab `c`
                    access: {push: {effects: [{impulse: 1 0 0}]}} ! 30 ! the item has no `physics`, so this action could never work
                    sensors: {ears: {hearing: true, lineOfSight: true}} ! 35 ! lineOfSight: a sensor with `hearing: true` hears voices and senses no items; leave it out
                    sensors: {ears: {hearing: true, camera: {size: [4, 4]}}} ! 35 ! camera: a sensor with `hearing: true` hears voices and senses no items; leave it out
                    sensors: {ears: {hearing: true, every: 2}}  ! 35 ! every: a sensor with `hearing: true` hears voices and senses no items; leave it out
                    sensors: {ears: {hearing: true, range: 0 m}} ! 42 ! range: 0.0 m is not more than 0
                    sensors: {ears: {hearing: loud}}            ! 29 ! hearing: found text `loud`, expected true or false
                    voice: {range: 3 kg}                        ! 18 ! range: unit kg does not fit m
                    voice: {range: -3 m}                        ! 18 ! range: -3.0 m is not more than 0
                    voice: {fading: 0}                          ! 19 ! fading: 0.0 m is not more than 0
                    voice: {loss: 1}                            ! 11 ! unknown key `loss`; known here: range, fading
                    voice: loud                                 ! 10 ! voice: found text `loud`, expected a mapping
                    """)
    void refusesInAnItem(String line, int column, String message) {
        assertThat(problems("reve: 1\nname: w\nitems:\n- name: one\n  " + line))
                .containsExactly("w:5:" + column + ": " + message);
    }

    @Test
    void anItemWithAVoiceHasNoActionOfItsOwnWithWhichToSpeak() {
        assertThat(
                        problems(
                                """
                                reve: 1
                                name: w
                                items:
                                - name: one
                                  voice: {range: 3 m}
                                  access: {say: {effects: [{raise: a}]}}
                                - {name: two, kind: spring, voice: {}, physics: {end1: one, end2: one}}
                                """))
                .contains(
                        "w:6:12: say: an item with a `voice` has an action of this name; "
                                + "rename this action, or leave out the voice",
                        "w:7:29: only items of kind body have a `voice`, this is a spring");
    }

    /** The effect of an action with parameters, on line 6. */
    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '!',
            quoteCharacter = '\'',
            textBlock =
                    """
                    impulse: $impluse                     ! impulse: the action has no parameter `impluse`; did you mean `impulse`?
                    impulse: $speed                       ! impulse: unit m/s of $speed does not fit N*s
                    impulse: $mass                        ! impulse: $mass has components: 1, expected 3
                    impulse: $word                        ! impulse: $word is no number
                    impulse: 1 2 3 kg                     ! impulse: unit kg does not fit N*s
                    impulse: [1, 2]                       ! impulse: found 2 numbers, expected 3 numbers in N*s
                    '{set: physics.mass, to: $speed}'     ! to: $speed has components: 3, expected 1
                    '{set: physics.mass, to: true}'       ! to: found `true`, expected numbers
                    '{set: physical.colour, to: $mass}'   ! to: a colour is a text, $mass is not
                    '{force: $speed}'                     ! force: unit m/s of $speed does not fit N
                    '{force: 1 0 0, for: -1 s}'           ! for: found -1.0 s, expected 0 s or longer
                    '{set: physics.mass, to: $mass + }'   ! to: the expression ends too early
                    '{set: physics.mass, to: $speed + 1}' ! to: `+` does not go with (list of numbers, number)
                    '{set: physics.mass, to: "$add(speed, speed)"}' ! to: `add(speed, speed)` is a list, expected a number
                    '{symbol: a, to: $weather == 1}'      ! to: unknown name `weather`; known are actor, impulse, item, mass, physical, physics, semantic, speed, word
                    '{symbol: a, to: $speed}'             ! to: a symbol takes one value, $speed has 3
                    """)
    void refusesInAnEffect(String effect, String message) {
        List<String> found =
                problems(
                        """
                        reve: 1
                        name: w
                        items:
                        - name: one
                          physics: {mass: 1}
                          access: {push: {parameters: {impulse: {components: 3, unit: N*s}, speed: {components: 3, unit: m/s}, mass: {unit: kg}, word: {type: text}}, effects: [%s]}}
                        """
                                .formatted(effect.startsWith("{") ? effect : "{" + effect + "}"));
        assertThat(found).hasSize(1);
        assertThat(found.getFirst()).matches("w:6:\\d+: .*").endsWith(": " + message);
    }

    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '!',
            quoteCharacter = '\'',
            textBlock =
                    """
                    {end1: a}           ! 3  ! a spring needs `end2`: The body at the other end.
                    {end1: a, end2: x}  ! 35 ! end2: no item is named `x`
                    {end1: a, end2: Apple} ! 35 ! end2: no item is named `Apple`; did you mean `apple`?
                    {end1: a, end2: a}  ! 35 ! end2: `a` is referred to twice; expected different items
                    {end1: a, end2: s}  ! 35 ! end2: `s` is a spring, expected a body
                    {end1: a, end2: c}  ! 35 ! end2: `c` has no `physics`, so nothing can hold on to it; mass 0 makes a body immovable
                    {end1: a, end2: 3}  ! 35 ! end2: found number 3, expected the name of a body
                    {end1: a, end2: [a]}! 35 ! end2: found a list of 1, expected the name of a body
                    """)
    void refusesReferences(String physics, int column, String message) {
        assertThat(
                        problems(
                                """
                                reve: 1
                                name: w
                                items:
                                - {name: a, physics: {mass: 1}}
                                - {name: c}
                                - {name: apple}
                                - name: s
                                  kind: spring
                                  physics:        %s
                                """
                                        .formatted(physics)))
                .containsExactly("w:9:" + column + ": " + message);
    }

    @Test
    void refusesDuplicateNamesWithTheFirstOnesLine() {
        assertThat(problems("reve: 1\nname: w\nitems:\n- name: a\n- name: b\n- name: a\n"))
                .containsExactly("w:6:9: duplicate item name `a`, first on line 4");
    }

    @Test
    void refusesSymbolsThatAnActionCouldNeverSet() {
        assertThat(
                        problems(
                                """
                                reve: 1
                                name: w
                                items:
                                - name: one
                                  access:
                                    write: {effects: [{symbol: note, to: "%s"}]}
                                    split: {effects: [{symbol: note, to: "\\uD800"}]}
                                """
                                        .formatted("x".repeat(5000))))
                .containsExactly(
                        "w:6:42: item one: note has 5000 characters, at most 4096 are allowed",
                        "w:7:43: `\\uD800` is half a character; write the character itself, or "
                                + "both halves, as in `\\uD83D\\uDE00`");
    }

    /** The names of these events belong to the server, and to the tools that read its events. */
    @ParameterizedTest
    @ValueSource(
            strings = {
                "joined",
                "left",
                "acted",
                "law-loaded",
                "law-unloaded",
                "law-shadow",
                "fault",
                "over-budget",
                "missed",
                "waiting",
                "ready",
                "standby",
                "cluster",
                "picture",
                "picture-failed",
                "saved",
                "rewound",
                "stalled",
                "recovered",
                "late",
                "away",
                "back",
                "end",
                "detached",
                "removed",
                "spoke",
                "heard",
                "world-asleep",
                "watching",
                "level-changed"
            })
    void refusesToRaiseAnEventOfTheServers(String event) {
        assertThat(
                        problems(
                                "reve: 1\nname: w\nitems:\n- name: one\n  access: {push: {effects: "
                                        + "[{raise: "
                                        + event
                                        + "}]}}"))
                .containsExactly(
                        "w:5:37: raise: the event "
                                + event
                                + " is the server's own; choose a name other than joined, left, "
                                + "acted, law-loaded, law-unloaded, law-shadow, fault, over-budget, "
                                + "missed, waiting, ready, standby, cluster, picture, picture-failed, "
                                + "saved, rewound, "
                                + "stalled, recovered, late, away, back, end, detached, "
                                + "removed, spoke, heard, world-asleep, watching and level-changed");
    }

    /** The name of a world becomes a part of file names. */
    @ParameterizedTest
    @ValueSource(strings = {"../up", "a/b", "..", ".hidden", "-x", " x", "é", "a:b", "a*"})
    void refusesAWorldNameThatCannotBePartOfAFileName(String name) {
        assertThat(problems("reve: 1\nname: \"" + name + "\"\n"))
                .containsExactly(
                        "w:2:7: name: found text `"
                                + name
                                + "`, expected a letter (a to z) or digit, then letters, digits,"
                                + " spaces, `.`, `_` or `-`: it becomes part of file names");
    }

    @Test
    void refusesReservedAndUnusableNames() {
        assertThat(problems("reve: 1\nname: w\nitems:\n- name: world\n- name: \"a\\n\"\n- {}\n"))
                .contains(
                        "w:4:9: name: `world` is the item that holds the constants; they belong "
                                + "under `constants`")
                .contains(
                        "w:5:9: name: found text `a `, expected a text that is not blank and "
                                + "holds no control characters")
                .contains("w:6:3: items[2]: `name` is missing");
    }

    @Test
    void whatIsDeclaredWronglyIsReportedThereOnly() {
        assertThat(
                        problems(
                                """
                                reve: 1
                                name: w
                                properties: [{name: heat, kind: body, unit: foo}, {name: mass, kind: body}]
                                constants: {heat: 3}
                                items: [{name: a, physics: {heat: 3 K, mass: 1}}]
                                """))
                .containsExactly(
                        "w:3:45: unit `foo`: `foo` is not a unit that is known here",
                        "w:3:58: property mass of kind body: the name is already taken by a"
                                + " property of kind body");
    }

    @Test
    void unquotedColourIsACommentAndSaysSo() {
        assertThat(
                        problems(
                                "reve: 1\nname: w\nitems:\n- name: a\n  physical:\n"
                                        + "    colour: #ff0000\n"))
                .containsExactly(
                        "w:6:12: colour: found nothing, expected a text; a # begins a comment, so"
                                + " put the colour in quotes");
    }

    @Test
    void aNumberThatA32BitWorldWouldLoseIsRefused() {
        assertThat(
                        problems(
                                """
                                reve: 1
                                name: w
                                prototype: si-f32
                                properties: [{name: n, kind: body, type: i32}, {name: u, kind: body, type: u32}]
                                items:
                                - name: a
                                  physical: {location: [1e39, 0, 0]}
                                  physics: {mass: 1e39, charge: 1e-60, n: 0.5, u: -1}
                                """))
                .containsExactly(
                        "w:7:24: location: 1.0E39 is not within the range of a 32-bit real; use"
                                + " prototype si-f64",
                        "w:8:19: mass: 1.0E39 is not within the range of a 32-bit real; use"
                                + " prototype si-f64",
                        "w:8:33: charge: 1.0E-60 would become 0 as a 32-bit real; use prototype"
                                + " si-f64",
                        "w:8:43: n: 0.5 is not a whole number from -2147483648 to 2147483647",
                        "w:8:51: u: -1.0 is not a whole number from 0 to 4294967295");
    }

    @Test
    void allProblemsComeAtOnceInTheOrderOfTheFile() {
        WorldFileException refused =
                refused(
                        """
                        reve: 2
                        items:
                        - name: a
                          physics: {mass: 3 s, charge: .nan}
                        - {name: a, phsics: {}}
                        """);
        assertThat(refused.problems()).isSorted();
        assertThat(refused.problems())
                .extracting(Problem::pointer)
                .containsExactlyInAnyOrder(
                        "/reve",
                        "",
                        "/items/0/physics/mass",
                        "/items/0/physics/charge",
                        "/items/1/name",
                        "/items/1/phsics");
        assertThat(refused)
                .hasMessage(
                        """
                        w:1:1: `name` is missing
                        w:1:7: reve: found number 2, expected 1, the format version that is read here
                        w:4:19: mass: unit s does not fit kg
                        w:4:32: charge: `.nan` is not a finite number
                        w:5:10: duplicate item name `a`, first on line 3
                        w:5:13: unknown key `phsics`; did you mean `physics`?\
                        """);
    }

    @Test
    void aReportHoldsAHundredProblemsAndSaysThatThereAreMore() {
        List<String> problems = problems("reve: 1\nname: w\nitems:\n" + "- {}\n".repeat(5000));
        assertThat(problems).hasSize(Problems.MAX_REPORTED + 1);
        assertThat(problems.getLast())
                .endsWith("no more than 100 problems are shown; there may be others");
    }

    /** The physical aspect of a spring or a surface, on line 6. */
    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '!',
            textBlock =
                    """
                    spring ! {width: -3 cm}   ! 36 ! width: found -0.03 m, expected 0 or more
                    spring ! {width: 3 kg}    ! 36 ! width: unit kg does not fit m
                    spring ! {width: 1e200}   ! 36 ! width: 1.0E200 is beyond 1e100; its powers would be no numbers, so expected a smaller one
                    spring ! {location: 1}    ! 29 ! `location` does not go with kind spring; in `physical`, a spring has only `colour` and `width`, and a surface only `colour`
                    surface ! {width: 3 cm}   ! 30 ! only items of kind spring have a `width`, this is a surface
                    body ! {width: 3 cm}      ! 27 ! only items of kind spring have a `width`, this is a body
                    """)
    void refusesInTheLookOf(String kind, String physical, int column, String message) {
        String physics =
                switch (kind) {
                    case "spring" -> "{end1: a, end2: b}";
                    case "surface" -> "{vertices: [a, b, c]}";
                    default -> "{mass: 1}";
                };
        assertThat(
                        problems(
                                "reve: 1\nname: w\nitems:\n- {name: a, physics: {mass: 1}}\n"
                                        + "- {name: b, like: a}\n"
                                        + "- {kind: "
                                        + kind
                                        + ", physical: "
                                        + physical
                                        + ", name: s, physics: "
                                        + physics
                                        + "}\n- {name: c, physics: {mass: 1}}\n"
                                        + "prefabs: {a: {physics: {mass: 1}}}"))
                .containsExactly("w:6:" + column + ": " + message);
    }
}
