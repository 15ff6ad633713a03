// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import reve.core.agent.port.WorldControl;
import reve.core.frame.FrameLoop;
import reve.core.frame.LawSwap;
import reve.core.frame.TimeBudget;
import reve.core.world.ActionRefused;
import reve.core.world.ItemId;
import reve.core.world.World;
import reve.core.world.WorldImage;
import reve.core.world.WorldSnapshot;

import java.util.Collection;
import java.util.Map;
import java.util.Optional;
import java.util.function.Consumer;

/** Keeps images of a world without physics; supports no other command. */
public record RoomControl(World world, FrameLoop loop, Image beginning) implements WorldControl {

    RoomControl(World world, FrameLoop loop) {
        this(world, loop, new Kept(world, loop));
    }

    @Override
    public Image keep() {
        return new Kept(world, loop);
    }

    @Override
    public Change loadLaw(String library, Map<String, Double> parameters, Optional<LawSwap> swap)
            throws ActionRefused {
        return WorldControl.none().loadLaw(library, parameters, swap);
    }

    @Override
    public Change loadText(
            String source, String text, Map<String, Double> parameters, Optional<LawSwap> swap)
            throws ActionRefused {
        return WorldControl.none().loadText(source, text, parameters, swap);
    }

    @Override
    public Change unloadLaw(String library) throws ActionRefused {
        return WorldControl.none().unloadLaw(library);
    }

    @Override
    public Change setLaw(String library, Map<String, Double> parameters, Optional<LawSwap> swap)
            throws ActionRefused {
        return WorldControl.none().setLaw(library, parameters, swap);
    }

    @Override
    public Change setBudget(String library, Optional<TimeBudget> budget) throws ActionRefused {
        return WorldControl.none().setBudget(library, budget);
    }

    @Override
    public Reading laws(boolean faults) throws ActionRefused {
        return WorldControl.none().laws(faults);
    }

    @Override
    public Map<String, Object> ledger(Optional<Boolean> open) throws ActionRefused {
        return WorldControl.none().ledger(open);
    }

    @Override
    public Change picture() throws ActionRefused {
        return WorldControl.none().picture();
    }

    @Override
    public Change changeRules(Map<String, Optional<String>> rules) throws ActionRefused {
        return WorldControl.none().changeRules(rules);
    }

    @Override
    public Change release(String library) throws ActionRefused {
        return WorldControl.none().release(library);
    }

    @Override
    public Object answer(String what, Map<String, Object> arguments) throws ActionRefused {
        return WorldControl.none().answer(what, arguments);
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
        public void save(String file, Collection<ItemId> without) throws ActionRefused {
            throw new ActionRefused("unsupported", "nothing is saved here");
        }

        @Override
        public void foresee(int frames, Change first, Consumer<WorldSnapshot> look)
                throws ActionRefused {
            String thread = Thread.currentThread().isVirtual() ? "virtual" : "platform";
            throw new ActionRefused(
                    "unsupported", "nothing is foreseen here, on a " + thread + " thread");
        }

        @Override
        public void close() {
            image.close();
        }
    }
}
