// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/** Mixing of hash codes for hash tables whose sizes are powers of 2. */
final class Hash {

    private Hash() {}

    /**
     * Mixes the bits of a hash code, so that similar codes differ in their low bits. Uses the last
     * steps of MurmurHash3 (A. Appleby, 2011).
     */
    static int spread(int code) {
        int hash = (code ^ code >>> 16) * 0x85EBCA6B;
        hash = (hash ^ hash >>> 13) * 0xC2B2AE35;
        return hash ^ hash >>> 16;
    }
}
