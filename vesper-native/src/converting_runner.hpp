// SPDX-License-Identifier: Apache-2.0
// A law that declares other units than the prototype, of the same dimension.
#pragma once

#include <memory>
#include <vector>

#include "kernels.hpp"
#include "law_runner.hpp"

namespace vesper {

/// Shows `law`, which `inner` drives, columns in its own units. `ratios`, one for each use, take
/// values of the prototype to the law; a ratio of one leaves the column as it is.
std::unique_ptr<LawRunner> MakeConvertingRunner(Law& law, std::unique_ptr<LawRunner> inner,
                                                std::vector<UnitRatio> ratios);

}  // namespace vesper
