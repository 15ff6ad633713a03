// SPDX-License-Identifier: Apache-2.0
package reve.worlds.demo;

import java.io.PrintWriter;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;

/**
 * The result of the demonstration of a cluster.
 *
 * @param world name of the world
 * @param nodes addresses of the nodes
 * @param killed address of the node that was killed
 * @param continued address of the node that continued the world
 * @param seenFrame last frame that a client had seen from the killed node
 * @param resumedFrame frame at which the world continued
 * @param epoch epoch in which the world continued
 * @param seconds time from the kill until a client was in the world again [s]
 * @param stateHash hash of the state with which the world continued
 * @param undisturbedHash hash of the state of a world that made as many frames without a kill
 * @param before picture of the world on the killed node
 * @param after picture of the world on the node that continued it
 */
public record ClusterDemoReport(
        String world,
        List<String> nodes,
        String killed,
        String continued,
        long seenFrame,
        long resumedFrame,
        long epoch,
        double seconds,
        String stateHash,
        String undisturbedHash,
        Picture before,
        Picture after) {
    /**
     * A picture.
     *
     * @param frame frame that it shows
     */
    public record Picture(long frame, String file) {
        Map<String, Object> fields() {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("frame", frame);
            fields.put("file", file);
            return fields;
        }
    }

    /** Returns whether the world continued with the state of a world that was never disturbed. */
    public boolean isSame() {
        return stateHash.equals(undisturbedHash);
    }

    /** Returns the report's fields for JSON. */
    public Map<String, Object> fields() {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("world", world);
        fields.put("nodes", nodes);
        fields.put("killed", killed);
        fields.put("continued", continued);
        fields.put("seenFrame", seenFrame);
        fields.put("resumedFrame", resumedFrame);
        fields.put("epoch", epoch);
        fields.put("seconds", seconds);
        fields.put("stateHash", stateHash);
        fields.put("undisturbedHash", undisturbedHash);
        fields.put("same", isSame());
        fields.put("before", before.fields());
        fields.put("after", after.fields());
        return fields;
    }

    /** Prints the report for human readers. */
    public void print(PrintWriter out) {
        out.printf(
                Locale.ROOT,
                """

                Three servers shared the worlds of a database. The server %s ran the world %s and
                was killed with kill -9. After %.1f s, the server %s continued the world at frame
                %d, in epoch %d. A client had seen frame %d before the kill.
                The state at frame %d %s the state of a world that was never disturbed (%s).

                picture   before  frame %d: %s
                picture   after   frame %d: %s
                """,
                killed,
                world,
                seconds,
                continued,
                resumedFrame,
                epoch,
                seenFrame,
                resumedFrame,
                isSame() ? "equals, to the bit," : "DIFFERS from",
                stateHash,
                before.frame(),
                before.file(),
                after.frame(),
                after.file());
    }
}
