// SPDX-License-Identifier: Apache-2.0
/**
 * Readers of shapes and textures from files of a {@link reve.core.mesh.WorldFolder}. The formats
 * are glTF 2.0, OBJ and COLLADA for meshes, PNG and JPEG for images, PNG and text for terrains.
 * Each file is read once. It is checked and limited before memory is allocated for it. {@link
 * reve.core.mesh.Assets} is the entry point. {@link reve.core.mesh.MassProperties} computes mass
 * and inertia of shapes.
 */
@NullMarked
package reve.core.mesh;

import org.jspecify.annotations.NullMarked;
