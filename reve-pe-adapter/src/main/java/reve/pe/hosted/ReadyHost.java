// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import reve.pe.PhysicsLaw;
import reve.pe.Prototype;
import reve.pe.vesper.VesperConfig;
import reve.pe.vesper.VesperLog;

import java.util.ArrayList;
import java.util.List;

/**
 * A host that has created its engine and loaded the libraries of a world, but has neither columns
 * nor state. It can replace a lost host of this world faster than a host without libraries.
 */
final class ReadyHost implements AutoCloseable {
    private static final VesperLog QUIET = (level, message) -> {};

    private final HostProcess host;
    private final List<Opened> opened;

    /** A library, and the reply of the host when it loaded the library. */
    private record Opened(Loaded library, int threads, int hostId, List<PhysicsLaw> laws) {}

    private ReadyHost(HostProcess host, List<Opened> opened) {
        this.host = host;
        this.opened = opened;
    }

    /**
     * Starts a host, and makes it load libraries. It uses copies of their files, because the world
     * may unload a library meanwhile. For any thread.
     *
     * @throws HostLost if the host ended
     * @throws RuntimeException if the host cannot be started, or refuses a library
     */
    static ReadyHost start(
            Hosts hosts,
            VesperConfig config,
            Prototype prototype,
            List<Loaded> libraries,
            long limitNanos)
            throws HostLost {
        HostProcess host = hosts.start();
        boolean ready = false;
        try {
            Calls calls =
                    request -> {
                        request.accept(host);
                        Mailbox reply = host.call(limitNanos, QUIET);
                        if (reply.getInt() != 0) {
                            throw Wire.Failure.read(reply).exception(0, "", "");
                        }
                        return reply;
                    };
            calls.create(config, config.threads(), prototype);
            List<Opened> opened = new ArrayList<>();
            for (Loaded library : libraries) {
                try (HostedLibrary copy = library.library.copy()) {
                    Mailbox reply = calls.call(to -> library.put(to.begin(Request.LOAD), copy));
                    opened.add(
                            new Opened(
                                    library,
                                    reply.getInt(),
                                    reply.getInt(),
                                    Wire.laws(reply, library.id)));
                }
            }
            ready = true;
            return new ReadyHost(host, opened);
        } finally {
            if (!ready) {
                host.close();
            }
        }
    }

    /**
     * Returns whether this host lives and has loaded these libraries in this order. The host may
     * also have other libraries, which the world has unloaded since then.
     */
    boolean fits(List<Loaded> libraries) {
        List<Loaded> own = new ArrayList<>(opened.stream().map(Opened::library).toList());
        own.retainAll(libraries);
        return own.equals(libraries) && host.isAlive();
    }

    /**
     * Unloads the libraries that the world has unloaded, and sets the ids and laws of the other
     * libraries.
     *
     * @param calls connection to {@link #host}
     * @return false if an unloaded library left a thread, which might write to columns; the host
     *     must not be used then
     */
    boolean handOver(Calls calls, List<Loaded> libraries) throws HostLost {
        for (Opened gone : opened) {
            if (!libraries.contains(gone.library)) {
                int threads =
                        calls.call(to -> to.begin(Request.UNLOAD).putInt(gone.hostId)).getInt();
                if (threads > gone.threads) {
                    return false;
                }
            }
        }
        for (Opened kept : opened) {
            if (libraries.contains(kept.library)) {
                kept.library.loadedAs(calls, kept.threads, kept.hostId, kept.laws);
            }
        }
        return true;
    }

    HostProcess host() {
        return host;
    }

    @Override
    public void close() {
        host.close();
    }
}
