// SPDX-License-Identifier: Apache-2.0
/**
 * Pictures of worlds. A {@link reve.worlds.render.Scene} is the content of one picture. A {@link
 * reve.worlds.render.SceneBuilder} fills it from a world snapshot. A {@link
 * reve.worlds.render.Renderer} draws it to a PNG in a separate process, {@code vesper-render}.
 */
@NullMarked
package reve.worlds.render;

import org.jspecify.annotations.NullMarked;
