// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.ParameterException;

import reve.core.file.NamedCamera;
import reve.core.file.WorldDescription;
import reve.core.text.Suggestion;
import reve.core.world.WorldSnapshot;
import reve.worlds.render.Camera;
import reve.worlds.render.CameraMount;
import reve.worlds.render.ImageFormat;
import reve.worlds.render.Scene;
import reve.worlds.server.Pictures;

import java.util.List;
import java.util.Optional;

/**
 * The camera that a command selected, or the camera of the world. For one thread. States of the
 * world must be passed in order of time.
 */
final class Viewpoint {
    private final ImageFormat format;
    private final Optional<CameraMount> mount;
    private final Optional<Camera> fixed;

    private Viewpoint(ImageFormat format, Optional<CameraMount> mount, Optional<Camera> fixed) {
        this.format = format;
        this.mount = mount;
        this.fixed = fixed;
    }

    /**
     * Returns the camera of the option {@code --camera}. Returns the camera of the world if the
     * option is missing.
     *
     * @param description the description of the world; empty for a recording without its world file
     */
    static Viewpoint of(
            CommandSpec spec,
            Optional<String> name,
            Optional<WorldDescription> description,
            ImageFormat format) {
        if (name.isEmpty()) {
            return new Viewpoint(
                    format,
                    Optional.empty(),
                    description.flatMap(WorldDescription::camera).map(Camera::of));
        }
        List<NamedCamera> all = description.map(WorldDescription::cameras).orElse(List.of());
        NamedCamera found =
                all.stream()
                        .filter(camera -> camera.name().equals(name.get()))
                        .findFirst()
                        .orElseThrow(() -> unknown(spec, name.get(), all));
        return new Viewpoint(format, Optional.of(new CameraMount(found)), Optional.empty());
    }

    private static ParameterException unknown(
            CommandSpec spec, String name, List<NamedCamera> all) {
        List<String> names = all.stream().map(NamedCamera::name).toList();
        String known =
                names.isEmpty()
                        ? "; the world file has no key `cameras`"
                        : Suggestion.of(name, names) + "; it has " + String.join(", ", names);
        return new ParameterException(
                spec.commandLine(), "--camera: the world has no camera `" + name + "`" + known);
    }

    /** Returns the scene of a state of the world. The caller may close the state afterwards. */
    Scene scene(WorldSnapshot snapshot) {
        Optional<Camera> camera = mount.map(moving -> moving.at(snapshot)).or(() -> fixed);
        return Pictures.sceneBuilder(format, camera).build(snapshot);
    }
}
