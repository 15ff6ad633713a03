// SPDX-License-Identifier: Apache-2.0
/**
 * The Vesper engine for any Java program. {@code VesperEngine} is the entry point; the C functions,
 * the layouts of their structs and raw addresses stay inside this package.
 */
@NullMarked
package reve.pe.vesper;

import org.jspecify.annotations.NullMarked;
