// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import reve.pe.PhysicsLaw;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.TreeMap;

/**
 * A loaded library with its laws. It also keeps the number of calls and the times of the laws in
 * all hosts (engine processes) so far.
 */
final class Loaded {
    final int id;
    final HostedLibrary library;
    final Map<String, Double> parameters;

    /** The library's id in the current host. */
    int hostId;

    /** Number of threads that the host had before the library was loaded. */
    int threads;

    /** Interval of the laws, see {@link reve.pe.PhysicsEngine#setInterval}. */
    int interval = 1;

    private List<PhysicsLaw> laws = List.of();

    /** Calls and times [ns] in the current host as last reported, by law. */
    private long[] counts = {};

    /** Calls and times [ns] in all earlier hosts, by law. */
    private long[] before = {};

    /** Whether a law rests, by law, as last reported. */
    private boolean[] resting = {};

    Loaded(int id, HostedLibrary library, Map<String, Double> parameters) {
        this.id = id;
        this.library = library;
        this.parameters = new TreeMap<>(parameters);
    }

    /** Loads the library into a host. */
    void load(Calls host) throws HostLost {
        Mailbox reply = host.call(to -> put(to.begin(Request.LOAD)));
        int before = reply.getInt();
        loadedAs(host, before, reply.getInt(), Wire.laws(reply, id));
    }

    /**
     * Sets the id and the laws that the library has in a host. Also sends the interval of the laws
     * to the host.
     *
     * @param threadsBefore number of threads of the host before it loaded the library
     */
    void loadedAs(Calls host, int threadsBefore, int idInHost, List<PhysicsLaw> lawsInHost)
            throws HostLost {
        threads = threadsBefore;
        hostId = idInHost;
        set(lawsInHost);
        if (interval != 1) {
            host.call(to -> to.begin(Request.SET_INTERVAL).putInt(hostId).putInt(interval));
        }
    }

    /**
     * Loads the library into a host in place of another library, and takes its id in this host.
     *
     * @return number of threads of the host afterwards
     */
    int replace(Calls host, Loaded old) throws HostLost {
        hostId = old.hostId;
        Mailbox reply = host.call(to -> put(to.begin(Request.REPLACE).putInt(hostId)));
        threads = reply.getInt();
        int after = reply.getInt();
        read(reply);
        return after;
    }

    private void put(Mailbox to) {
        put(to, library);
    }

    /**
     * Appends the library and its parameters to a request.
     *
     * @param file object that contains the bytes of the library
     */
    void put(Mailbox to, HostedLibrary file) {
        Mailbox request = file.put(to).putInt(parameters.size());
        parameters.forEach((name, value) -> request.putText(name).putDouble(value));
    }

    /** Reads the laws as the current host describes them. */
    void read(Mailbox from) {
        set(Wire.laws(from, id));
    }

    private void set(List<PhysicsLaw> now) {
        laws = now;
        counts = new long[2 * laws.size()];
        resting = new boolean[laws.size()];
        for (int law = 0; law < laws.size(); law++) {
            counts[2 * law] = laws.get(law).calls();
            counts[2 * law + 1] = laws.get(law).nanoseconds();
            resting[law] = laws.get(law).resting();
        }
        if (before.length == 0) {
            before = new long[counts.length];
        }
    }

    /** Reads the calls and times of the laws, and whether they rest. */
    void count(Mailbox from) {
        for (int law = 0; law < resting.length; law++) {
            counts[2 * law] = from.getLong();
            counts[2 * law + 1] = from.getLong();
            resting[law] = from.getInt() != 0;
        }
    }

    /**
     * Writes the time of each law in all hosts to {@code into} from an index on, and returns the
     * index after the last one.
     */
    int readTimes(long[] into, int first) {
        int at = first;
        for (int i = 1; i < counts.length; i += 2) {
            into[at++] = before[i] + counts[i];
        }
        return at;
    }

    /** Adds the counts of a host that has ended to those of earlier hosts. */
    void keepCounts() {
        for (int i = 0; i < counts.length; i++) {
            before[i] += counts[i];
            counts[i] = 0;
        }
    }

    /** Returns the laws with their calls and times in all hosts, and whether they rest. */
    List<PhysicsLaw> laws() {
        List<PhysicsLaw> all = new ArrayList<>();
        for (int i = 0; i < laws.size(); i++) {
            PhysicsLaw law = laws.get(i);
            all.add(
                    new PhysicsLaw(
                            id,
                            law.library(),
                            law.name(),
                            law.version(),
                            law.doc(),
                            law.phase(),
                            law.stages(),
                            law.claims(),
                            law.uses(),
                            law.parameters(),
                            before[2 * i] + counts[2 * i],
                            before[2 * i + 1] + counts[2 * i + 1],
                            resting[i]));
        }
        return all;
    }

    String lawName(int index) {
        return index >= 0 && index < laws.size() ? laws.get(index).name() : "";
    }
}
