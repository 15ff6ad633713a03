// SPDX-License-Identifier: Apache-2.0
// A law library as a file, and as code that is called without an engine.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "vesper/engine.h"
#include "vesper/law.h"

namespace vesper {

/// A mapped law library, or a text that was compiled for the standard prototypes. Throws
/// std::runtime_error if it cannot be loaded.
class LawFile {
 public:
  explicit LawFile(const std::string& path);

  /// Returns NAME of a path that ends with libvesper_law_NAME.so or NAME.law.
  static std::string NameOf(const std::string& path);

  const vesper_law_library& table() const { return *table_; }
  bool is_text() const { return prepared_ != nullptr; }
  /// Returns the laws of one precision, in the order of the table.
  std::vector<const vesper_law_desc*> Laws(vesper_scalar_type real_type) const;
  /// Returns the fields that it provides for FIELD properties.
  std::span<const vesper_field_desc> Fields() const;

  /// Returns the names of the symbols that it exports.
  std::vector<std::string> Exports() const;
  /// Returns the file names of the libraries that it needs at load.
  std::vector<std::string> Needed() const;
  /// Returns "symbol (file that provides it)" for each imported symbol.
  std::vector<std::string> Imports() const;

 private:
  struct Close {
    void operator()(void* handle) const;
  };
  struct Symbol {
    std::string name;
    bool defined;
    bool weak;
  };
  std::vector<Symbol> DynamicSymbols() const;

  struct Discard {
    void operator()(vesper_prepared_library* prepared) const { vesper_library_discard(prepared); }
  };

  std::string path_;
  std::unique_ptr<void, Close> handle_;                           // null: a text
  std::unique_ptr<vesper_prepared_library, Discard> prepared_{};  // of a text
  const vesper_law_library* table_;
};

/// One law, created and bound without an engine, on one thread.
class BareLaw {
 public:
  /// Creates and binds the law. `properties`: one per use of the law, with borrowed arrays.
  /// `library`: library of the law if it needs a suite; the suite then belongs to this object
  /// alone.
  BareLaw(const vesper_law_desc& desc, const std::vector<vesper_property>& properties,
          const vesper_law_library* library = nullptr);

  double PotentialEnergy() const;

  struct Time {
    double dt;       // [s]
    uint64_t index;  // index of the step
  };
  /// Runs one step: stage 0 if the law is an integrator that begins there, then each stage after
  /// `evaluate(stage)`, which may write forces. The arrays are current before and after each call,
  /// also for deferred uses.
  void Step(const Time& time, const std::function<void(uint32_t)>& evaluate) const;

 private:
  void Advance(const vesper_step& step) const;

  struct Close {
    const vesper_law_library* library;
    void operator()(vesper_suite* suite) const { library->close(suite); }
  };
  struct Destroy {
    const vesper_law_desc* desc;
    void operator()(vesper_law* law) const { desc->destroy(law); }
  };

  void Bind() const;
  void TakeArrays() const;

  const vesper_law_desc& desc_;
  vesper_host host_;
  mutable std::vector<vesper_property> properties_;
  std::unique_ptr<vesper_suite, Close> suite_;
  std::unique_ptr<vesper_law, Destroy> law_;
};

}  // namespace vesper
