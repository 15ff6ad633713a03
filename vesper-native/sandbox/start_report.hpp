// SPDX-License-Identifier: Apache-2.0
// Reports of a starting sandbox to the engine's process, sent before the sandbox opens the library.
#pragma once

#include <cstdint>

#include "confinement.hpp"

namespace vesper::apart {

struct StartReport {
  int32_t process;  ///< process id of the sandbox, from the process that starts it; else 0
  Layers layers;    ///< layers of the sandbox, which sends them as soon as it is confined
};

}  // namespace vesper::apart
