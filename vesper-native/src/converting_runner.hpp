// SPDX-License-Identifier: Apache-2.0
// Runner of a law whose units differ in scale from the units of the prototype.
#pragma once

#include <memory>
#include <vector>

#include "kernels.hpp"
#include "law_runner.hpp"

namespace vesper {

/// Returns a runner that converts columns to the units of `law` and back, and lets `inner` run the
/// law on them. `ratios`, one for each use, convert from the prototype's unit to the law's; a ratio
/// of one leaves the column unchanged.
std::unique_ptr<LawRunner> MakeConvertingRunner(Law& law, std::unique_ptr<LawRunner> inner,
                                                std::vector<UnitRatio> ratios);

}  // namespace vesper
