// SPDX-License-Identifier: Apache-2.0
/**
 * Text for people: safe display of untrusted text, rounded numbers, and suggestions for misspelt
 * names.
 */
@NullMarked
package reve.core.text;

import org.jspecify.annotations.NullMarked;
