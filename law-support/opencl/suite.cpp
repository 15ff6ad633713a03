// SPDX-License-Identifier: Apache-2.0
#include "suite.hpp"

#include <algorithm>
#include <bit>

#include "kernels.hpp"

namespace vesper::opencl {

uint32_t Suite::Width(size_t real_size) const {
  return std::bit_floor(std::clamp(device.VectorWidth(real_size), 1u, 16u));
}

std::unique_ptr<Kernel> Suite::Compile(const char* kernel, size_t real_size, bool fast) {
  const bool doubles = real_size == sizeof(double);
  if (doubles) device.RequireDoubles();
  std::string options = doubles ? "-DREAL=double -DDOUBLES" : "-DREAL=float";
  options += " -DWIDTH=" + std::to_string(Width(real_size));
  if (fast) options += " -DFAST";
  return device.Compile(kSource, options, kernel);
}

}  // namespace vesper::opencl
