// SPDX-License-Identifier: Apache-2.0
// A law library on its way from a file to an engine.
#pragma once

#include <string>

#include "config.hpp"
#include "descriptor.hpp"
#include "law_table.hpp"
#include "vesper/engine.h"

namespace vesper {

/// A sealed in-memory copy of a file, named by its content. Nothing of it is in any file system, so
/// that nothing is left behind and nobody can change it.
class SealedCopy {
 public:
  /// `library` as vesper_library_prepare takes it.
  SealedCopy(const Config& config, const std::string& library);

  int fd() const { return memory_.get(); }
  /// Under this name the loader finds the copy. No two copies that live share it.
  const std::string& path() const { return path_; }
  /// The file it was copied from, for messages.
  const std::string& source() const { return source_; }
  /// Leaves the copy to the process, as long as the loader still holds on to its name.
  void Abandon() { memory_.Release(); }

 private:
  std::string source_;
  std::string path_;
  Descriptor memory_;
};

/// The copy as the loader has mapped it. Unmaps it when dropped.
class MappedLibrary {
 public:
  MappedLibrary(const Config& config, const std::string& library);
  ~MappedLibrary();
  MappedLibrary(const MappedLibrary&) = delete;
  MappedLibrary& operator=(const MappedLibrary&) = delete;

  /// Asks its entry.
  LawTable Table() const;

 private:
  SealedCopy copy_;
  void* handle_ = nullptr;
};

}  // namespace vesper

/// A library that is probed, mapped and checked, but belongs to no engine yet.
struct vesper_prepared_library {
  vesper_prepared_library(const vesper::Config& config, const std::string& library)
      : mapped_(config, library), table_(mapped_.Table()) {}

  const vesper_law_library& table() const { return table_.library(); }

 private:
  vesper::MappedLibrary mapped_;
  vesper::LawTable table_;
};
