// SPDX-License-Identifier: Apache-2.0
// Memory of the client, mapped into the host.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>

namespace vesper::host {

/// The client's memory behind a descriptor, between two pages that fault when they are touched.
/// A forked child does not inherit it, and the descriptor is closed once the memory is mapped.
class Mapping {
 public:
  Mapping() = default;
  /// Maps `size` bytes from `offset` on of descriptor `fd` of process `client`. Throws
  /// std::runtime_error.
  Mapping(int client, uint32_t fd, uint64_t size, bool writable, uint64_t offset = 0);
  Mapping(Mapping&& other) noexcept { *this = std::move(other); }
  Mapping& operator=(Mapping&& other) noexcept;
  ~Mapping();

  std::byte* data() const { return data_; }
  uint64_t size() const { return size_; }
  /// Permits writes, or makes them fault.
  void SetWritable(bool writable);

 private:
  std::byte* data_ = nullptr;
  uint64_t size_ = 0;
  uint64_t lead_ = 0;  ///< bytes of the first page before the data
  bool writable_ = false;
};

/// The mapped columns by property. A column that no loaded law may write is read-only, so a law
/// that writes what it declared READ faults.
class Columns {
 public:
  struct Arrays {
    Mapping data;
    Mapping indices;
  };

  /// Replaces the arrays of a property; returns the old ones, which the engine may still use.
  Arrays Replace(const std::string& property, Arrays arrays);
  void Remove(const std::string& property) { arrays_.erase(property); }
  bool IsWritable(const std::string& property) const { return writable_.contains(property); }
  /// Returns the property whose column contains the address, or null; sets the offset in it
  /// [bytes]. Allocates nothing, so that a signal handler can call it.
  const char* Find(const void* address, uint64_t& offset) const;
  /// Sets the properties that may be written.
  void SetWritable(std::set<std::string> properties);

 private:
  std::map<std::string, Arrays> arrays_;
  std::set<std::string> writable_;
};

}  // namespace vesper::host
