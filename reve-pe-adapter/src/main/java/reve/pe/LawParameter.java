// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/**
 * A parameter that a law declares.
 *
 * @param unit that the law expects
 * @param standard value if the client gives none [unit]
 */
public record LawParameter(String name, SiUnit unit, double standard) {}
