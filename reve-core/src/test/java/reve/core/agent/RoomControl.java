package reve.core.agent;

import java.util.Map;
import reve.core.frame.FrameLoop;
import reve.core.world.ActionRefused;
import reve.core.world.World;
import reve.core.world.WorldImage;

/** Keeps images of a world without physics, and can do nothing else. */
record RoomControl(World world, FrameLoop loop, Image beginning) implements WorldControl {

    RoomControl(World world, FrameLoop loop) {
        this(world, loop, new Kept(world, loop));
    }

    @Override
    public Image keep() {
        return new Kept(world, loop);
    }

    @Override
    public Change loadLaw(String library, Map<String, Double> parameters) throws ActionRefused {
        return WorldControl.none().loadLaw(library, parameters);
    }

    @Override
    public Change unloadLaw(String library) throws ActionRefused {
        return WorldControl.none().unloadLaw(library);
    }

    @Override
    public Change picture() throws ActionRefused {
        return WorldControl.none().picture();
    }

    private record Kept(World world, FrameLoop loop, WorldImage image) implements Image {

        Kept(World world, FrameLoop loop) {
            this(world, loop, new WorldImage(world));
            image.copyFrom(world, loop.frame());
        }

        @Override
        public long rewind() {
            long frame = loop.frame() + 1;
            loop.continueAfter(frame);
            world.restore(image);
            return frame;
        }

        @Override
        public void close() {
            image.close();
        }
    }
}
