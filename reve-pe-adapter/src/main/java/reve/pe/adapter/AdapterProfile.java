package reve.pe.adapter;

/**
 * Where the adapter's time went so far, wall clock; for people, never for the world.
 *
 * @param frames advanced
 * @param redoneFrames times a frame was done over because a law failed
 * @param bindNanoseconds telling the engine what changed in the world
 * @param copyNanoseconds keeping and restoring the columns that laws may write
 * @param advanceNanoseconds inside the engine
 */
public record AdapterProfile(long frames, long redoneFrames, long bindNanoseconds,
                             long copyNanoseconds, long advanceNanoseconds) {
}
