// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import reve.pe.posix.SharedMemory;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Objects;

/**
 * The state that only the engine has (see {@link reve.pe.PhysicsEngine#saveState}), after the last
 * successful call that changed it. A host writes this state into shared memory. This object keeps a
 * copy that no host can change.
 */
final class KeptState {
    private static final long FIRST_BYTES = 1 << 16;

    private SharedMemory shared = new SharedMemory("vesper-host state", FIRST_BYTES);
    private byte[] copy = {};
    private int size;
    private long steps;

    /** Libraries that were unloaded since the state was kept; their state is not restored. */
    private final List<String> left = new ArrayList<>();

    /** Passes the shared memory to a host. */
    void lend(Calls host) throws HostLost {
        host.call(
                to ->
                        to.begin(Request.STATE_MEMORY)
                                .putInt(shared.descriptor())
                                .putLong(shared.segment().byteSize()));
    }

    /** Requests the state of a host, and keeps it. */
    void keep(Calls host) throws HostLost {
        while (!keep(host.call(to -> to.begin(Request.SAVE_STATE)))) {
            lend(host);
        }
    }

    /**
     * Copies the state that the host wrote before this reply.
     *
     * @return false if the state did not fit into the shared memory; the memory is larger
     *     afterwards
     */
    boolean keep(Mailbox reply) {
        long counted = reply.getLong();
        long bytes = reply.getLong();
        if (reply.getInt() == 0) {
            SharedMemory larger =
                    new SharedMemory(
                            "vesper-host state", Math.max(bytes, 2 * shared.segment().byteSize()));
            shared.close();
            shared = larger;
            return false;
        }
        Objects.checkIndex(bytes, Math.min(shared.segment().byteSize(), Integer.MAX_VALUE) + 1);
        steps = counted;
        size = (int) bytes;
        if (copy.length < size) {
            copy = new byte[Math.max(size, 2 * copy.length)];
        }
        MemorySegment.copy(shared.segment(), ValueLayout.JAVA_BYTE, 0, copy, 0, size);
        left.clear();
        return true;
    }

    /**
     * Loads the kept state into a new host. Requests and keeps the state of the host if there is no
     * kept state. In the first case the state of the host need not be requested, because the next
     * advance sends it.
     */
    void restore(Calls host) throws HostLost {
        if (size > 0) {
            load(bytes(), left, host);
        } else {
            keep(host);
        }
    }

    /** Makes a host load a state without the state of the libraries {@code without}. */
    void load(byte[] state, List<String> without, Calls host) throws HostLost {
        if (shared.segment().byteSize() < state.length) {
            shared.close();
            shared = new SharedMemory("vesper-host state", state.length);
            lend(host);
        }
        MemorySegment.copy(state, 0, shared.segment(), ValueLayout.JAVA_BYTE, 0, state.length);
        host.call(
                to -> {
                    Mailbox request =
                            to.begin(Request.LOAD_STATE)
                                    .putLong(state.length)
                                    .putInt(without.size());
                    without.forEach(request::putText);
                });
    }

    /** Replaces the kept state by an earlier one. */
    void set(Saved saved) {
        set(saved.bytes, saved.steps);
    }

    /**
     * Replaces the kept state by bytes that a host of the present laws has accepted.
     *
     * @param count step count in the state
     */
    void set(byte[] state, long count) {
        copy = state.clone();
        size = copy.length;
        steps = count;
        left.clear();
    }

    /** Returns the kept state, for {@link #set(Saved)}. */
    Saved saved() {
        return new Saved(bytes(), steps);
    }

    /** A state of the engine, and its step count. */
    record Saved(byte[] bytes, long steps) {}

    /** Excludes the state of a library that was unloaded while there was no host. */
    void leave(String library) {
        left.add(library);
    }

    long steps() {
        return steps;
    }

    byte[] bytes() {
        return Arrays.copyOf(copy, size);
    }

    void close() {
        shared.close();
    }
}
