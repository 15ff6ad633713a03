// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.pe.Status;

/**
 * A law library that failed and stays out until it is released.
 *
 * @param sha256 of the library's bytes: what is refused, whatever its file is called
 * @param frame in which it failed
 * @param message what the engine said about it
 */
public record Quarantined(
        String sha256, String library, long frame, Status status, String message) {}
