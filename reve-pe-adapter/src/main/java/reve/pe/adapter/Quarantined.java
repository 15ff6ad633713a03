// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.pe.Status;

/**
 * A law library that failed and stays unloaded until it is released.
 *
 * @param sha256 SHA-256 of the library's bytes, which identifies it independently of its file name
 * @param frame frame in which it failed
 * @param message message of the engine
 */
public record Quarantined(
        String sha256, String library, long frame, Status status, String message) {}
