// SPDX-License-Identifier: Apache-2.0
// State that the OpenCL laws of one library share.
#pragma once

#include <memory>
#include <optional>

#include "device.hpp"

namespace vesper::opencl {

/** A column on the device, (rows x components) as on the host, with the version of the host's
 *  array from which it was copied. The suite's own laws write to the device only, so they do not
 *  change that version. */
class DeviceColumn {
 public:
  explicit DeviceColumn(Device& device) : buffer_(device) {}

  /** Copies the host's array if its version has changed. */
  template <class Column>
  void Take(const Column& column) {
    if (version_ == column.version()) return;
    buffer_.Upload(column.data(), column.size() * sizeof *column.data());
    version_ = column.version();
  }
  /** Allocates memory for a kernel that writes all rows. From this call on, the data on the device
   *  is valid and the host's array is stale. */
  template <class Column>
  void Overwrite(const Column& column) {
    buffer_.Reserve(column.size() * sizeof *column.data());
    version_ = column.version();
  }
  /** Writes the copy to the host's array. */
  template <class Column>
  void Give(const Column& column) {
    buffer_.Download(column.data(), column.size() * sizeof *column.data());
  }
  const Buffer& buffer() const { return buffer_; }

 private:
  Buffer buffer_;
  std::optional<uint64_t> version_;
};

/** The device and its columns; one for each engine that loads the library. */
class Suite {
 public:
  /** Returns a kernel of kernels.hpp for this real type. Throws if the device does not support
   *  doubles. */
  template <class Real>
  std::unique_ptr<Kernel> Compile(const char* kernel, bool fast = false) {
    return Compile(kernel, sizeof(Real), fast);
  }
  /** Returns the number of bodies that a work item of the gravitation kernel processes. */
  template <class Real>
  uint32_t Width() const {
    return Width(sizeof(Real));
  }

  Device device;
  DeviceColumn mass{device}, position{device}, velocity{device}, force{device};

 private:
  std::unique_ptr<Kernel> Compile(const char* kernel, size_t real_size, bool fast);
  uint32_t Width(size_t real_size) const;
};

}  // namespace vesper::opencl
