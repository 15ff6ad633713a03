// SPDX-License-Identifier: Apache-2.0
// What the OpenCL laws of one library share.
#pragma once

#include <memory>
#include <optional>

#include "device.hpp"

namespace vesper::opencl {

/** A column on the device, (rows x components) as on the host, and the version of the host's array
 *  that it was taken from. What the suite's own laws write to it leaves that version as it is. */
class DeviceColumn {
 public:
  explicit DeviceColumn(Device& device) : buffer_(device) {}

  /** Takes the host's array if somebody else wrote it since. */
  template <class Column>
  void Take(const Column& column) {
    if (version_ == column.version()) return;
    buffer_.Upload(column.data(), column.size() * sizeof *column.data());
    version_ = column.version();
  }
  /** Makes room for what a kernel writes to all rows; from then on the copy counts. */
  template <class Column>
  void Overwrite(const Column& column) {
    buffer_.Reserve(column.size() * sizeof *column.data());
    version_ = column.version();
  }
  /** Writes the host's array. */
  template <class Column>
  void Give(const Column& column) {
    buffer_.Download(column.data(), column.size() * sizeof *column.data());
  }
  const Buffer& buffer() const { return buffer_; }

 private:
  Buffer buffer_;
  std::optional<uint64_t> version_;
};

/** The device, and the columns on it; one for each engine that loads the library. */
class Suite {
 public:
  /** A kernel of kernels.hpp, for reals of that type. Throws if the device lacks doubles. */
  template <class Real>
  std::unique_ptr<Kernel> Compile(const char* kernel, bool fast = false) {
    return Compile(kernel, sizeof(Real), fast);
  }
  /** Bodies that a work item of gravitation takes at once. */
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
