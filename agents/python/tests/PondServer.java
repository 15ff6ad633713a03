import java.io.IOException;
import java.nio.file.Path;
import java.util.List;
import reve.core.agent.AgentServer;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.WorldControl;
import reve.core.agent.WorldPort;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.CommandQueue;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.world.OffHeapArena;
import reve.core.world.SnapshotRing;
import reve.core.world.World;

/**
 * Serves a world file, without physics, on an ephemeral port, for the tests beside it: prints the port, then makes
 * frames until its standard input ends. Run as a source file.
 */
final class PondServer {

    public static void main(String[] arguments) throws Exception {
        WorldDescription description = WorldFile.load(Path.of(arguments[0]));
        World world = description.build(new OffHeapArena());
        var bus = new FrameBus();
        var commands = new CommandQueue(1024);
        commands.subscribeTo(bus);
        var snapshots = new SnapshotRing(world, 3);
        bus.subscribe(FramePhase.PUBLISH, "snapshots",
                event -> snapshots.publish(event.frame(), event.timeSeconds()));
        var loop = new FrameLoop(world, bus, description.timing(), Pacing.REAL_TIME);
        var port = new WorldPort(world.name(), description.timing().framesPerSecond(), description.agents(), bus,
                commands, snapshots, loop, WorldControl.none());
        try (AgentServer server = AgentServer.start(AgentServerConfig.onPort(0), List.of(port))) {
            System.out.println(server.address().getPort());
            Thread.ofVirtual().start(() -> {
                while (readByte() >= 0) {
                    // Nothing is expected but the end.
                }
                loop.stop();
            });
            loop.run();
        }
    }

    private static int readByte() {
        try {
            return System.in.read();
        } catch (IOException e) {
            return -1;
        }
    }
}
