package reve.core.frame;

/** Something that takes part in frames. */
@FunctionalInterface
public interface FrameListener {

    /** Called on the world's thread, in the phase subscribed to; must not keep the event. */
    void onFrame(FrameEvent event);
}
