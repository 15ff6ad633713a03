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
#include "vesper/vesper.hpp"

namespace vesper {

/// A mapped law library, or a text or a file in Python that was prepared for the standard
/// prototypes. Throws std::runtime_error if it cannot be loaded.
class LawFile {
 public:
  explicit LawFile(const std::string& path);

  /// Returns NAME of a path that ends with libvesper_law_NAME.so, NAME.law or NAME.py.
  static std::string NameOf(const std::string& path);
  /// Returns the file name of a library `name` in the same form as the file `path`. For example,
  /// returns `name`.law if `path` is a text.
  static std::string FileNameFor(const std::string& path, const std::string& name);
  static bool IsPython(const std::string& path);
  /// Prepares a library of any form for engines of a prototype. Throws std::runtime_error.
  static PreparedLibrary Prepare(const vesper_prototype& prototype, const std::string& path);

  /// Returns the table, whose laws may depend on the precision if the file is in Python.
  const vesper_law_library& table(vesper_scalar_type real_type = VESPER_F64) const {
    return real_type == VESPER_F32 && f32_table_ != nullptr ? *f32_table_ : *table_;
  }
  /// Returns whether the file is a shared object, not a text or a file in Python.
  bool is_native() const { return handle_ != nullptr; }
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
  using Prepared = std::unique_ptr<vesper_prepared_library, Discard>;

  static Prepared PrepareFile(const vesper_prototype& prototype, const std::string& path);

  std::string path_;
  std::unique_ptr<void, Close> handle_;  // null: not a shared object
  Prepared prepared_{};                  // tables of a text, or of a file in Python for f64
  Prepared f32_prepared_{};              // tables of a file in Python for f32
  const vesper_law_library* table_;
  const vesper_law_library* f32_table_ = nullptr;
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
