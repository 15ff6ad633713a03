// SPDX-License-Identifier: Apache-2.0
/** Makes untrusted text safe to display. */
@NullMarked
package reve.core.text;

import org.jspecify.annotations.NullMarked;
