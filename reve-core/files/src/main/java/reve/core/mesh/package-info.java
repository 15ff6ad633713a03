// SPDX-License-Identifier: Apache-2.0
/**
 * From files of a {@link reve.core.mesh.WorldFolder} to shapes and textures: glTF 2.0 and OBJ
 * meshes, PNG and JPEG images, read once, checked and limited before memory is taken for them.
 * {@link reve.core.mesh.Assets} is the way in; {@link reve.core.mesh.MassProperties} weighs shapes.
 */
@NullMarked
package reve.core.mesh;

import org.jspecify.annotations.NullMarked;
