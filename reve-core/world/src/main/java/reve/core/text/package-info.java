// SPDX-License-Identifier: Apache-2.0
/** Untrusted text, made safe to display. */
@NullMarked
package reve.core.text;

import org.jspecify.annotations.NullMarked;
