// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import reve.pe.PhysicsException;
import reve.pe.Prototype;
import reve.pe.Status;
import reve.pe.vesper.VesperConfig;
import reve.pe.vesper.VesperLog;

import java.time.Duration;

/**
 * Tests a library in a separate host (engine process): opens it, and creates and destroys its laws.
 * A library that crashes or hangs in this test therefore never reaches a world. For any thread.
 */
record Trial(Hosts hosts, VesperConfig config, Prototype prototype) {
    private static final long LIMIT_NANOS = Duration.ofSeconds(10).toNanos();
    private static final VesperLog QUIET = (level, message) -> {};

    /** Maximum number of trials that end by SIGKILL, which another program may have sent. */
    private static final int MOST_KILLS = 3;

    /**
     * Tests the library, and sets its name and the versions of the programs that it uses. Ends
     * early if the calling thread is interrupted.
     *
     * @throws PhysicsException if the library cannot be opened or ends the process; the library is
     *     closed then
     */
    void test(HostedLibrary library) {
        int tries = 1;
        while (!isTested(library, tries == MOST_KILLS)) {
            tries++;
        }
    }

    /**
     * Tests the library in a new process.
     *
     * @return false if SIGKILL ended the process, and a new process must test the library
     */
    private boolean isTested(HostedLibrary library, boolean isLast) {
        String stage = "opening it";
        try (HostProcess host = hosts.start()) {
            host.endWhenInterrupted();
            Calls calls =
                    request -> {
                        request.accept(host);
                        Mailbox reply = host.call(LIMIT_NANOS, QUIET);
                        if (reply.getInt() != 0) {
                            throw Wire.Failure.read(reply).exception(0, "", "");
                        }
                        return reply;
                    };
            calls.create(config, 1, prototype);
            Mailbox opened = calls.call(to -> library.put(to.begin(Request.PREPARE)));
            library.declared(opened.getText(), opened.getText());
            stage = "creating or destroying its laws";
            tryToLoad(host, library);
            return true;
        } catch (HostLost lost) {
            if (Thread.currentThread().isInterrupted()) {
                library.close();
                throw new PhysicsException(
                        Status.LIBRARY_LOAD_FAILED,
                        library.source()
                                + ": it was not tested to the end, because the server ends");
            }
            if (lost.killed && !isLast) {
                return false;
            }
            library.close();
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED,
                    library.source()
                            + (lost.isLate()
                                    ? ": the library gave "
                                    : ": the library ended a trial process, ")
                            + lost.getMessage()
                            + ", while "
                            + stage);
        } catch (RuntimeException refused) {
            library.close();
            throw refused;
        }
    }

    /**
     * Loads and unloads the library. Only a crash is a failure. The refusal of a law by the engine
     * of this process is ignored. The engine of the world checks whether the laws fit the world
     * when it loads the library.
     */
    private static void tryToLoad(HostProcess host, HostedLibrary library) throws HostLost {
        library.put(host.begin(Request.LOAD)).putInt(0);
        Mailbox loaded = host.call(LIMIT_NANOS, QUIET);
        if (loaded.getInt() == 0) {
            loaded.getInt(); // this call skips the number of threads
            int id = loaded.getInt();
            host.begin(Request.UNLOAD).putInt(id);
            host.call(LIMIT_NANOS, QUIET);
            return;
        }
        PhysicsException refused = Wire.Failure.read(loaded).exception(0, "", "");
        if (library.isApart()
                && (refused.status() == Status.LAW_CRASHED
                        || refused.status() == Status.LAW_TIMED_OUT)) {
            throw new PhysicsException(
                    Status.LIBRARY_LOAD_FAILED,
                    library.source() + ": " + refused.getMessage() + ", while it was created");
        }
    }
}
