// SPDX-License-Identifier: Apache-2.0
#include "scene.hpp"

#include <array>
#include <ranges>
#include <span>

#include "csv_reader.hpp"
#include "drawing_reader.hpp"
#include "folders.hpp"
#include "galaxy.hpp"
#include "generators.hpp"
#include "scene_files.hpp"
#include "scene_reader.hpp"

namespace vesper::cli {
namespace {

constexpr double kLargestColumn = 1e9;  // maximum number of values

using Names = std::vector<std::string>;

/// Interpreter of the lines of a scene.
class SceneParser {
 public:
  SceneParser(std::string text, const std::string& file, bool trusted)
      : reader_(std::move(text), file), files_(file, trusted) {
    scene_.file = file;
    scene_.prototype = &StandardPrototype("si-f64");
  }

  Scene Parse() {
    ReadHeader();
    while (reader_.NextLine()) {
      ReadLine();
      reader_.ExpectEnd();
    }
    if (scene_.dt == 0) throw SceneError(reader_.Here(), "the scene has no 'dt'");
    return std::move(scene_);
  }

 private:
  struct Statement {
    const char* name;
    void (SceneParser::*read)();
  };
  static const std::array<Statement, 13> kStatements;

  void ReadHeader() {
    if (!reader_.NextLine() || !reader_.Accept("scene") ||
        reader_.Number("the version of the format") != 1) {
      throw SceneError({scene_.file, 1, 1}, "expected 'scene 1' in the first line");
    }
    reader_.ExpectEnd();
  }

  void ReadLine() {
    Names names;
    const std::string word = reader_.Word("a statement");
    for (const Statement& statement : kStatements) {
      if (word == statement.name) return (this->*statement.read)();
      names.push_back(statement.name);
    }
    for (const auto* property : PropertiesOf(kind_)) names.push_back(property->name);
    AnyColumn column = TakeColumn(word, names);
    ReadColumn(reader_, scene_, column);
    Keep(word, std::move(column));
  }

  /// Returns the properties for which a scene can contain values. Fields are functions, which law
  /// libraries provide.
  auto Properties() const {
    return std::span(scene_.prototype->properties, scene_.prototype->property_count) |
           std::views::filter([](const auto& p) { return p.scalar_type != VESPER_FIELD; });
  }

  std::vector<const vesper_property_descriptor*> PropertiesOf(const std::string& kind) const {
    std::vector<const vesper_property_descriptor*> found;
    for (const auto& property : Properties()) {
      if (property.kind == kind) found.push_back(&property);
    }
    return found;
  }

  Names Kinds() const {
    Names kinds;
    for (const auto& property : Properties()) {
      if (std::ranges::find(kinds, property.kind) == kinds.end()) kinds.push_back(property.kind);
    }
    return kinds;
  }

  /// Returns the column of the property named by the last word, or a new column of zeros.
  AnyColumn TakeColumn(const std::string& name, const Names& known) {
    for (const auto& property : Properties()) {
      if (property.name != name) continue;
      if (property.kind != kind_) {
        reader_.FailLast("'" + name + "' is a property of " + property.kind +
                         (kind_.empty() ? "" : ", not of " + kind_) + "; it belongs below 'rows " +
                         property.kind + " …'");
      }
      if ((property.law_access & VESPER_ACCUMULATE) != 0) {
        reader_.FailLast("'" + name + "' is summed up by the engine and cannot be given" +
                         (property.initial_from == nullptr
                              ? std::string()
                              : "; give '" + std::string(property.initial_from) + "' instead"));
      }
      if (property.scalar_type == VESPER_I32 || property.scalar_type == VESPER_U32) {
        reader_.RefuseUnit("'" + name + "' is a whole number without a unit");
      }
      reader_.UseUnit(property.unit, "'" + name + "'");
      const auto found = scene_.columns.find(name);
      if (found != scene_.columns.end()) return found->second;
      const uint64_t rows = scene_.rows.at(kind_);
      if (static_cast<double>(rows) * property.components > kLargestColumn) {
        reader_.FailLast("'" + name + "' would have more than 1e9 values");
      }
      return AnyColumn(property, rows);
    }
    reader_.FailUnknown(kind_.empty() ? "statement" : "statement or property of " + kind_, known);
  }

  void Keep(const std::string& name, AnyColumn column) {
    scene_.columns.insert_or_assign(name, std::move(column));
    scene_.places.insert_or_assign(name, reader_.LineStart());
  }

  void ReadPrototype() {
    if (!scene_.rows.empty()) reader_.FailLast("must come before the first 'rows'");
    const Names known{"si-f64", "si-f32"};
    const std::string name = reader_.Word("a prototype");
    const vesper_unit time = scene_.prototype->time_unit;
    if (name.find_first_of("./") != std::string::npos) {
      LoadPrototype(name);
    } else if (std::ranges::find(known, name) == known.end()) {
      reader_.FailUnknown("prototype", known);
    } else {
      scene_.prototype = &StandardPrototype(name);
    }
    if (scene_.dt != 0 && scene_.prototype->time_unit.scale != time.scale) {
      reader_.FailLast("has another unit of time; expected it before 'dt'");
    }
  }

  void LoadPrototype(const std::string& path) {
    const std::string text = Read(path);
    if (text.find('\0') != std::string::npos) {
      reader_.FailLast("'" + path + "' contains a zero byte; expected text");
    }
    try {
      scene_.own_prototype.emplace(text, path.substr(path.rfind('/') + 1));
    } catch (const Error& error) {
      reader_.FailLast(error.what());
    }
    scene_.prototype = &scene_.own_prototype->get();
  }

  /// Returns the bytes of the file that the last word names.
  std::string Read(const std::string& path) const {
    try {
      return files_.Read(path);
    } catch (const std::runtime_error& error) {
      reader_.FailLast(error.what());
    }
  }

  void ReadDt() {
    reader_.UseUnit(scene_.prototype->time_unit, "time");
    scene_.dt = reader_.Quantity("the length of a step in seconds");
    if (scene_.dt <= 0) reader_.FailLast("expected a time above 0");
  }

  void ReadSteps() {
    scene_.steps = static_cast<uint32_t>(reader_.Count("the number of steps per frame", 1));
  }

  void ReadLaw() {
    SceneLaw law{reader_.Word("the name of a law library"), {}, reader_.Last()};
    if (law.library.find('/') != std::string::npos) {
      if (!files_.trusted()) {
        reader_.FailLast("'" + law.library +
                         "' is a path; a scene names laws by name, such as newton_motion: put the "
                         "library into a folder of --laws, or run the scene with --trust, which "
                         "opens the library with all of your rights");
      }
      law.library = files_.PathOf(law.library);
    }
    while (!reader_.AtEnd()) {
      const std::string name = reader_.Word("the name of a parameter");
      reader_.Expect("=");
      law.parameters.push_back({name, reader_.Number("the value of " + name)});
    }
    scene_.laws.push_back(std::move(law));
  }

  void ReadRows() {
    kind_ = reader_.Word("a kind");
    const Names kinds = Kinds();
    if (std::ranges::find(kinds, kind_) == kinds.end()) reader_.FailUnknown("kind", kinds);
    if (scene_.rows.contains(kind_)) {
      reader_.FailLast("the rows of " + kind_ + " were given before");
    }
    if (reader_.Accept("from")) {
      const std::string name = reader_.Word("the name of a CSV file");
      ReadCsvRows(Read(name), files_.PathOf(name), kind_, scene_);
      for (const auto* property : PropertiesOf(kind_)) {
        scene_.places.insert_or_assign(property->name, reader_.LineStart());
      }
    } else {
      scene_.rows[kind_] = reader_.Count("the number of rows", 0);
    }
    if (kind_ == "world" && scene_.rows[kind_] != 1) reader_.FailLast("the world has 1 row");
  }

  /// Reads the line: at ROW…: PROPERTY VALUE
  void ReadAt() {
    if (kind_.empty()) reader_.FailLast("must come after 'rows'");
    const auto rows = reader_.RowNumbers(scene_.rows.at(kind_), kind_);
    if (rows.empty()) throw SceneError(reader_.Here(), "expected row numbers");
    reader_.Expect(":");
    Names names;
    for (const auto* property : PropertiesOf(kind_)) names.push_back(property->name);
    const std::string name = reader_.Word("a property");
    AnyColumn column = TakeColumn(name, names);
    if (scene_.Find(name) == nullptr) {
      reader_.FailLast("'" + name + "' has no values yet; give it for all rows first");
    }
    const Value value = ReadRow(reader_, column);
    for (const uint64_t row : rows) SetRow(reader_, column, row, value);
    Keep(name, std::move(column));
  }

  void ReadCsv() {
    Names names;
    for (const auto& property : Properties()) names.push_back(property.name);
    while (!reader_.AtEnd()) {
      scene_.csv.push_back(reader_.Word("a property"));
      if (std::ranges::find(names, scene_.csv.back()) == names.end()) {
        reader_.FailUnknown("property", names);
      }
    }
  }

  template <void (*read)(SceneReader&, Scene&)>
  void Apply() {
    read(reader_, scene_);
  }

  SceneReader reader_;
  SceneFiles files_;
  Scene scene_;
  std::string kind_;  // kind of the rows being described
};

const std::array<SceneParser::Statement, 13> SceneParser::kStatements{{
    {"prototype", &SceneParser::ReadPrototype},
    {"dt", &SceneParser::ReadDt},
    {"steps", &SceneParser::ReadSteps},
    {"law", &SceneParser::ReadLaw},
    {"rows", &SceneParser::ReadRows},
    {"at", &SceneParser::ReadAt},
    {"csv", &SceneParser::ReadCsv},
    {"image", &SceneParser::Apply<ReadImage>},
    {"camera", &SceneParser::Apply<ReadCamera>},
    {"background", &SceneParser::Apply<ReadBackground>},
    {"ground", &SceneParser::Apply<ReadGround>},
    {"draw", &SceneParser::Apply<ReadDraw>},
    {"galaxy", &SceneParser::Apply<ReadGalaxy>},
}};

}  // namespace

const AnyColumn* Scene::Find(const std::string& property) const {
  const auto found = columns.find(property);
  return found == columns.end() ? nullptr : &found->second;
}

Scene ReadScene(const std::string& file, bool trusted) {
  return ParseScene(ReadFile(file), file, trusted);
}

Scene ParseScene(std::string text, const std::string& file, bool trusted) {
  return SceneParser(std::move(text), file, trusted).Parse();
}

}  // namespace vesper::cli
