// SPDX-License-Identifier: Apache-2.0
// A law library that was opened from its file but is not yet loaded into an engine.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "config.hpp"
#include "descriptor.hpp"
#include "law_table.hpp"
#include "prototype.hpp"
#include "text_library.hpp"
#include "vesper/engine.h"

namespace vesper {

/// A sealed copy of a file, named by its content. The copy exists in memory only. Therefore the
/// copy leaves no file on the disk, and no process can change it.
class SealedCopy {
 public:
  /// Copies `bytes` of a file that messages call `source`.
  SealedCopy(std::span<const std::byte> bytes, const std::string& source);

  int fd() const { return memory_.get(); }
  /// Returns the path under which the loader finds the copy. No two living copies share a path.
  const std::string& path() const { return path_; }
  /// Returns the file it was copied from, for messages.
  const std::string& source() const { return source_; }
  /// Keeps the copy until the process ends, because the loader still uses its name.
  void Abandon() { memory_.Release(); }

 private:
  std::string source_;
  std::string path_;
  Descriptor memory_;
};

/// The copy of a library, mapped by the loader; unmapped at destruction.
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

/// A library that was checked, but belongs to no engine yet: a mapped file, a text, or a table that
/// another program part has built.
struct vesper_prepared_library {
  /// Opens `library`, given as in vesper_library_prepare.
  vesper_prepared_library(const vesper::Config& config, const std::string& library);
  /// Opens a shared object or a text from its bytes.
  vesper_prepared_library(const vesper::Config& config, std::span<const std::byte> bytes,
                          const std::string& source);
  vesper_prepared_library(std::string source, std::string text);
  /// Creates a prepared library from a table that another program part has built.
  explicit vesper_prepared_library(const vesper_law_library& table);
  ~vesper_prepared_library();
  vesper_prepared_library(const vesper_prepared_library&) = delete;
  vesper_prepared_library& operator=(const vesper_prepared_library&) = delete;

  /// Sets `release(user)` to be called when this object is destroyed; null: nothing is called.
  void ReleaseAtEnd(void (*release)(void* user), void* user);
  const char* name() const;
  /// Returns the table, which lives as long as this object. A text is compiled for the prototype
  /// first.
  const vesper_law_library& TableFor(const vesper::Prototype& prototype);

 private:
  void Map(const vesper::Config& config, std::span<const std::byte> bytes,
           const std::string& source);

  std::unique_ptr<vesper::MappedLibrary> mapped_;
  std::unique_ptr<vesper::text::TextLibrary> text_;
  std::vector<std::unique_ptr<vesper::LawTable>> tables_;
  void (*release_)(void* user) = nullptr;
  void* released_ = nullptr;
};
