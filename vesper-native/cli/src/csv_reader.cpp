// SPDX-License-Identifier: Apache-2.0
#include "csv_reader.hpp"

#include <algorithm>
#include <span>

#include "csv.hpp"
#include "generators.hpp"
#include "nearest_name.hpp"

namespace vesper::cli {
namespace {

/// The column of a scene that receives the numbers of one column of the file. `property` is null if
/// the file's column is skipped.
struct Target {
  const vesper_property_descriptor* property = nullptr;
  uint32_t component = 0;
};

class CsvReader {
 public:
  CsvReader(std::string text, const std::string& file)
      : text_(std::move(text)), place_{file, 0, 1} {}

  /// Reads the cells of the next line; returns false at the end.
  bool NextLine() {
    cells_.clear();
    if (at_ >= text_.size()) return false;
    size_t end = std::min(text_.find('\n', at_), text_.size());
    ++place_.line;
    std::string_view line = std::string_view(text_).substr(at_, end - at_);
    if (line.ends_with('\r')) line.remove_suffix(1);
    for (size_t begin = 0; begin <= line.size();) {
      const size_t comma = std::min(line.find(',', begin), line.size());
      cells_.push_back(
          {std::string(line.substr(begin, comma - begin)), static_cast<int>(begin) + 1});
      begin = comma + 1;
    }
    at_ = end + 1;
    return true;
  }

  const std::vector<Token>& cells() const { return cells_; }

  [[noreturn]] void Fail(int column, const std::string& message) {
    place_.line = std::max(place_.line, 1);
    place_.column = column;
    throw SceneError(place_, message);
  }

  double Number(size_t cell) {
    double number;
    if (ParseNumber(cells_[cell].text, number)) return number;
    Fail(cells_[cell].column, "found '" + cells_[cell].text + "'; expected a number");
  }

 private:
  std::string text_;
  size_t at_ = 0;
  Place place_;
  std::vector<Token> cells_;
};

class RowsReader {
 public:
  RowsReader(CsvReader reader, const std::string& kind, Scene& scene)
      : reader_(std::move(reader)), kind_(kind), scene_(scene) {}

  void Read() {
    ReadNames();
    while (reader_.NextLine()) ReadRow();
    const uint64_t rows = targets_.empty() ? 0 : numbers_.size() / targets_.size();
    scene_.rows[kind_] = rows;
    for (const auto* property : properties_) {
      scene_.columns.insert_or_assign(property->name, AnyColumn(*property, rows));
    }
    for (size_t i = 0; i < numbers_.size(); ++i) {
      const Target& target = targets_[i % targets_.size()];
      if (target.property == nullptr) continue;
      scene_.columns.at(target.property->name)
          .Set(i / targets_.size() * target.property->components + target.component, numbers_[i]);
    }
  }

 private:
  void ReadNames() {
    if (!reader_.NextLine()) reader_.Fail(1, "the file is empty; expected names of properties");
    for (const Token& cell : reader_.cells()) {
      if (cell.text == "frame") frame_cell_ = targets_.size();
      const bool passed_over = cell.text == "frame" || cell.text == "time" || cell.text == "row";
      targets_.push_back(passed_over ? Target{} : FindTarget(cell));
    }
    for (const auto* property : properties_) {
      const auto cells = std::ranges::count(targets_, property, &Target::property);
      if (static_cast<size_t>(cells) == property->components) continue;
      reader_.Fail(1, "'" + std::string(property->name) + "' has " +
                          std::to_string(property->components) + " components, found " +
                          std::to_string(cells));
    }
  }

  Target FindTarget(const Token& cell) {
    std::vector<std::string> names;
    const auto& prototype = *scene_.prototype;
    for (const auto& property : std::span(prototype.properties, prototype.property_count)) {
      if (property.kind != kind_ || property.scalar_type == VESPER_FIELD) continue;
      for (uint32_t component = 0; component < property.components; ++component) {
        names.push_back(CsvColumnName(property, component));
        if (names.back() != cell.text) continue;
        if ((property.law_access & VESPER_ACCUMULATE) != 0) {
          reader_.Fail(cell.column,
                       "'" + cell.text + "' is summed up by the engine and cannot be given");
        }
        for (const Target& other : targets_) {
          if (other.property == &property && other.component == component) {
            reader_.Fail(cell.column, "'" + cell.text + "' is there twice");
          }
        }
        if (std::ranges::find(properties_, &property) == properties_.end()) {
          properties_.push_back(&property);
        }
        return {&property, component};
      }
    }
    const std::string* nearest = NearestName(cell.text, names);
    reader_.Fail(cell.column, "'" + cell.text + "' is no property of " + kind_ +
                                  (nearest == nullptr ? "" : "; did you mean '" + *nearest + "'?"));
  }

  void ReadRow() {
    const auto& cells = reader_.cells();
    if (cells.size() != targets_.size()) {
      reader_.Fail(1, std::to_string(cells.size()) + " cells; expected " +
                          std::to_string(targets_.size()) + ", as in the first line");
    }
    if (frame_cell_ < targets_.size()) {
      const double frame = reader_.Number(frame_cell_);
      if (frame != frame_) numbers_.clear();
      frame_ = frame;
    }
    for (size_t i = 0; i < cells.size(); ++i) {
      const double number = reader_.Number(i);
      if (targets_[i].property != nullptr && !CanHold(*targets_[i].property, number)) {
        reader_.Fail(cells[i].column, "the type of '" + std::string(targets_[i].property->name) +
                                          "' cannot hold this number");
      }
      numbers_.push_back(number);
    }
  }

  CsvReader reader_;
  const std::string& kind_;
  Scene& scene_;
  std::vector<Target> targets_;  // one per cell of a line
  std::vector<const vesper_property_descriptor*> properties_;
  size_t frame_cell_ = SIZE_MAX;
  double frame_ = -1;
  std::vector<double> numbers_;  // (rows x cells)
};

}  // namespace

void ReadCsvRows(std::string text, const std::string& file, const std::string& kind, Scene& scene) {
  RowsReader(CsvReader(std::move(text), file), kind, scene).Read();
}

}  // namespace vesper::cli
