/** Agents worth watching. */
@NullMarked
package reve.agent.examples;

import org.jspecify.annotations.NullMarked;
