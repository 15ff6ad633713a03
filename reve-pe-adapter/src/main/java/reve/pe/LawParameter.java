// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/**
 * A parameter that a law declares.
 *
 * @param unit that the law expects
 */
public record LawParameter(String name, SiUnit unit) {}
