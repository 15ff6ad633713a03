// SPDX-License-Identifier: Apache-2.0
// The usual OpenCL kernel for gravitation of all pairs, written without an engine: separate arrays
// of x, y, z and mass, one work item for each body, relaxed mathematics.
#pragma once

#include <array>
#include <vector>

#include "device.hpp"

namespace bench {

class SoaKernel {
 public:
  /// Uploads `columns`: x, y, z and mass of the bodies.
  explicit SoaKernel(const std::array<std::vector<float>, 4>& columns)
      : count_(columns[0].size()),
        kernel_(device_.Compile(kSource, "-cl-fast-relaxed-math", "attract")) {
    for (size_t i = 0; i < columns.size(); ++i) in_[i].Upload(columns[i].data(), count_ * 4);
    for (auto& buffer : out_) buffer.Reserve(count_ * 4);
  }

  /// Computes the accelerations of all bodies, which stay on the device.
  void Run(float softening2) {
    (*kernel_)(count_, in_[0], in_[1], in_[2], in_[3], out_[0], out_[1], out_[2],
               static_cast<cl_uint>(count_), softening2);
    device_.Finish();
  }

 private:
  using Buffer = vesper::opencl::Buffer;

  static constexpr const char* kSource = R"(
__kernel void attract(__global const float* x, __global const float* y, __global const float* z,
                      __global const float* mass, __global float* ax, __global float* ay,
                      __global float* az, uint count, float softening2) {
  const uint i = get_global_id(0);
  const float xi = x[i], yi = y[i], zi = z[i];
  float sx = 0, sy = 0, sz = 0;
  for (uint j = 0; j < count; ++j) {
    const float dx = x[j] - xi, dy = y[j] - yi, dz = z[j] - zi;
    const float inverse = rsqrt(dx * dx + dy * dy + dz * dz + softening2);
    const float pull = mass[j] * inverse * inverse * inverse;
    sx += pull * dx;
    sy += pull * dy;
    sz += pull * dz;
  }
  ax[i] = sx;
  ay[i] = sy;
  az[i] = sz;
})";

  vesper::opencl::Device device_;
  size_t count_;
  std::array<Buffer, 4> in_{Buffer(device_), Buffer(device_), Buffer(device_), Buffer(device_)};
  std::array<Buffer, 3> out_{Buffer(device_), Buffer(device_), Buffer(device_)};
  std::unique_ptr<vesper::opencl::Kernel> kernel_;
};

}  // namespace bench
