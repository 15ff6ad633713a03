// SPDX-License-Identifier: Apache-2.0
/**
 * Plugins: jars of an operator with actions, symbols, sensors and frame listeners that are written
 * in Java.
 */
@NullMarked
package reve.core.plugin;

import org.jspecify.annotations.NullMarked;
