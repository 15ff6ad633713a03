// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import reve.core.agent.port.WorldPort;
import reve.core.file.CameraDescription;

import java.util.Optional;

/**
 * A world that web pages can show.
 *
 * @param camera the first viewpoint; if empty, the page shows all bodies
 */
public record PageWorld(WorldPort port, Optional<CameraDescription> camera) {}
