// SPDX-License-Identifier: Apache-2.0
/** Foreign text, made safe to show. */
@NullMarked
package reve.core.text;

import org.jspecify.annotations.NullMarked;
