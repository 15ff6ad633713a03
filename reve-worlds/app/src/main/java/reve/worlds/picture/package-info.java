// SPDX-License-Identifier: Apache-2.0
/** Pictures and videos as files: layers of pictures, labels, contact sheets, and encoders. */
@NullMarked
package reve.worlds.picture;

import org.jspecify.annotations.NullMarked;
