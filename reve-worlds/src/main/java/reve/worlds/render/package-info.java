// SPDX-License-Identifier: Apache-2.0
/**
 * Pictures of worlds. A {@link reve.worlds.render.Scene} is what one picture shows, a {@link
 * reve.worlds.render.SceneBuilder} fills it from a world snapshot, and a {@link
 * reve.worlds.render.Renderer} turns it into a PNG in a process of its own, {@code vesper-render}.
 */
@NullMarked
package reve.worlds.render;

import org.jspecify.annotations.NullMarked;
