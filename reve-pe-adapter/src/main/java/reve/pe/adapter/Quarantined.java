// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.pe.Status;

/**
 * A law library that failed and stays unloaded until it is released.
 *
 * @param sha256 of the library's bytes, which identify it independently of its file name
 * @param frame in which it failed
 * @param message of the engine
 */
public record Quarantined(
        String sha256, String library, long frame, Status status, String message) {}
