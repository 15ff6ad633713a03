// SPDX-License-Identifier: Apache-2.0
// Reports of a starting sandbox to the engine's process, sent before the sandbox opens the library.
#pragma once

#include <cstdint>

#include "confinement.hpp"

namespace vesper::apart {

struct StartReport {
  int32_t process;  ///< from the process that starts the sandbox: its process id; else 0
  Layers layers;    ///< from the sandbox itself, as soon as it is confined
};

}  // namespace vesper::apart
