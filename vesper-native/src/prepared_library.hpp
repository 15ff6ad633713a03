// SPDX-License-Identifier: Apache-2.0
// A law library between its file and its engine.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "config.hpp"
#include "descriptor.hpp"
#include "law_table.hpp"
#include "vesper/engine.h"

namespace vesper {

/// A sealed in-memory copy of a file, named by its content. It is in no file system, so no file
/// remains and no process can change it.
class SealedCopy {
 public:
  /// Copies `library`, given as in vesper_library_prepare.
  SealedCopy(const Config& config, const std::string& library);
  /// Copies `bytes` of a file that messages call `source`.
  SealedCopy(std::span<const std::byte> bytes, const std::string& source);

  int fd() const { return memory_.get(); }
  /// Returns the path under which the loader finds the copy. No two living copies share a path.
  const std::string& path() const { return path_; }
  /// Returns the file it was copied from, for messages.
  const std::string& source() const { return source_; }
  /// Keeps the copy open until the process ends, because the loader still uses its name.
  void Abandon() { memory_.Release(); }

 private:
  std::string source_;
  std::string path_;
  Descriptor memory_;
};

/// The copy as mapped by the loader. Unmaps it at destruction.
class MappedLibrary {
 public:
  MappedLibrary(const Config& config, SealedCopy copy);
  ~MappedLibrary();
  MappedLibrary(const MappedLibrary&) = delete;
  MappedLibrary& operator=(const MappedLibrary&) = delete;

  /// Calls the library's entry function and returns its tables.
  LawTable Table() const;

 private:
  SealedCopy copy_;
  void* handle_ = nullptr;
};

}  // namespace vesper

/// A library that was probed, mapped and checked, but belongs to no engine yet.
struct vesper_prepared_library {
  vesper_prepared_library(const vesper::Config& config, vesper::SealedCopy copy)
      : mapped_(config, std::move(copy)), table_(mapped_.Table()) {}

  const vesper_law_library& table() const { return table_.library(); }

 private:
  vesper::MappedLibrary mapped_;
  vesper::LawTable table_;
};
