// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/**
 * A parameter that a law declares.
 *
 * @param unit unit that the law expects; the following numbers are in this unit
 * @param standard default value
 * @param minimum smallest permitted value
 * @param maximum largest permitted value
 */
public record LawParameter(
        String name, String doc, SiUnit unit, double standard, double minimum, double maximum) {}
