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

/// A mapping of the client's memory, between two guard pages. Any access to a guard page causes a
/// memory fault. A forked child process does not inherit the mapping. The descriptor is closed as
/// soon as the memory is mapped.
class Mapping {
 public:
  Mapping() = default;
  /// Maps `size` bytes, from `offset` on, of the memory that process `client` has as descriptor
  /// `fd`. Throws std::runtime_error.
  Mapping(int client, uint32_t fd, uint64_t size, bool writable, uint64_t offset = 0);
  Mapping(Mapping&& other) noexcept { *this = std::move(other); }
  Mapping& operator=(Mapping&& other) noexcept;
  ~Mapping();

  std::byte* data() const { return data_; }
  uint64_t size() const { return size_; }
  /// Permits writes to the memory, or makes them fault.
  void SetWritable(bool writable);

 private:
  std::byte* data_ = nullptr;
  uint64_t size_ = 0;
  uint64_t lead_ = 0;  ///< bytes between the start of the first page and the data
  bool writable_ = false;
};

/// The mapped columns by property. A column that no loaded law may write is read-only, so a law
/// that writes to such a column causes a memory fault.
class Columns {
 public:
  struct Arrays {
    Mapping data;
    Mapping indices;
  };

  /// Replaces the arrays of a property; returns the old ones, which the caller keeps as long as the
  /// engine uses them.
  Arrays Replace(const std::string& property, Arrays arrays);
  void Remove(const std::string& property) { arrays_.erase(property); }
  bool IsWritable(const std::string& property) const { return writable_.contains(property); }
  /// Returns the property whose column contains the address, or null; sets `offset` to the position
  /// in the column [bytes]. Allocates nothing, so that a signal handler can call it.
  const char* Find(const void* address, uint64_t& offset) const;
  /// Makes the columns of these properties writable, and all others read-only.
  void SetWritable(std::set<std::string> properties);

 private:
  std::map<std::string, Arrays> arrays_;
  std::set<std::string> writable_;
};

}  // namespace vesper::host
