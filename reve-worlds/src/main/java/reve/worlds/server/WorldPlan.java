package reve.worlds.server;

import reve.core.file.WorldDescription;

/**
 * A world that a server is to run.
 *
 * @param frames to make, then it ends
 * @param persistence where it comes from, if it is stored, and what is kept of the run
 * @param pictures to be taken of it; closed by the server
 */
public record WorldPlan(WorldDescription description, long frames, Persistence persistence,
                        Pictures pictures) {}
