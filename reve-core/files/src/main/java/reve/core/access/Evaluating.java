// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import reve.core.rule.Expression;
import reve.core.world.Item;

/**
 * Description of an action's expression that the world's thread is evaluating. Reports of a slow
 * world use it.
 *
 * @param what the purpose of the expression: {@code condition} or {@code value}
 */
record Evaluating(String what, Expression expression, Item target) {
    @Override
    public String toString() {
        return what + " `" + expression + "` of an action of " + target.name();
    }
}
