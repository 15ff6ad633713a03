// SPDX-License-Identifier: Apache-2.0
#include "scene_reader.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "nearest_name.hpp"
#include "vesper/vesper.hpp"

namespace vesper::cli {
namespace {

constexpr double kLargestCount = 1e9;

}  // namespace

SceneReader::SceneReader(std::string text, std::string file)
    : text_(std::move(text)), place_{std::move(file), 0, 1} {}

bool SceneReader::NextLine() {
  next_ = 0;
  tokens_.clear();
  unit_.reset();
  unit_used_ = false;
  scale_ = 1;
  while (tokens_.empty() && at_ < text_.size()) {
    const size_t end = std::min(text_.find('\n', at_), text_.size());
    ++place_.line;
    line_length_ = end - at_;
    tokens_ = Tokenize(std::string_view(text_).substr(at_, line_length_), place_);
    at_ = end + 1;
  }
  if (tokens_.size() > 1 && tokens_.back().is_unit()) {
    unit_ = tokens_.back();
    tokens_.pop_back();
  }
  return !tokens_.empty();
}

bool SceneReader::Accept(const std::string& text) {
  if (AtEnd() || tokens_[next_].quoted || tokens_[next_].text != text) return false;
  ++next_;
  return true;
}

const Token& SceneReader::Take(const std::string& what) {
  if (AtEnd()) throw SceneError(Here(), "the line ends; expected " + what);
  return tokens_[next_++];
}

std::string SceneReader::Word(const std::string& what) {
  const Token& token = Take(what);
  if (!token.quoted && token.text.find_first_of("():=") != std::string::npos) {
    FailLast("found '" + token.text + "'; expected " + what);
  }
  return token.text;
}

double SceneReader::Number(const std::string& what) {
  const std::string text = Take(what).text;
  double number;
  if (!ParseNumber(text, number)) {
    FailLast("found '" + text + "'; expected " + what + ", a number such as 1.5, 2e-3 or 1/240");
  }
  return number;
}

double SceneReader::Quantity(const std::string& what) {
  const double number = scale_ * Number(what);
  if (!std::isfinite(number)) FailLast("too large for a number in that unit");
  return number;
}

uint64_t SceneReader::Count(const std::string& what, uint64_t minimum) {
  const double number = Number(what);
  if (number != std::floor(number) || number < static_cast<double>(minimum) ||
      number > kLargestCount) {
    FailLast("expected " + what + ", a whole number from " + std::to_string(minimum) + " to 1e9");
  }
  return static_cast<uint64_t>(number);
}

Value SceneReader::ReadValue(const std::string& what) {
  if (!Accept("(")) return {Quantity(what)};
  Value value;
  while (!Accept(")")) {
    if (AtEnd()) throw SceneError(Here(), "'(' without its ')'");
    value.push_back(Quantity(what));
  }
  return value;
}

std::vector<uint64_t> SceneReader::RowNumbers(uint64_t rows, const std::string& kind) {
  std::vector<uint64_t> numbers;
  while (!Peek().empty() && std::isdigit(static_cast<unsigned char>(Peek()[0])) != 0) {
    const std::string word = Word("a row");
    const size_t dots = word.find("..");
    double first, last;
    if (!ParseNumber(word.substr(0, dots), first) ||
        !ParseNumber(dots == std::string::npos ? word : word.substr(dots + 2), last) ||
        first != std::floor(first) || last != std::floor(last) || last < first) {
      FailLast("expected a row number, or a range such as 3..7");
    }
    if (last >= static_cast<double>(rows)) {
      FailLast(kind + " has " + std::to_string(rows) + " rows; they count from 0");
    }
    for (auto row = static_cast<uint64_t>(first); row <= static_cast<uint64_t>(last); ++row) {
      numbers.push_back(row);
    }
  }
  return numbers;
}

void SceneReader::UseUnit(const vesper_unit& unit, const std::string& what) {
  if (!unit_) return;
  vesper_unit given{};
  try {
    given = ParseUnit(unit_->text.substr(1, unit_->text.size() - 2));
  } catch (const Error& error) {
    FailUnit(error.what());
  }
  if (!std::ranges::equal(given.exponent, unit.exponent)) {
    FailUnit(unit_->text + " is no unit of " + what + "; expected one of the same dimension as [" +
             unit.symbol + "]");
  }
  scale_ = given.scale / unit.scale;
  unit_used_ = true;
}

void SceneReader::RefuseUnit(const std::string& reason) const {
  if (unit_) FailUnit(reason);
}

void SceneReader::FailUnit(const std::string& message) const {
  Place place = place_;
  place.column = unit_->column;
  throw SceneError(place, message);
}

void SceneReader::ExpectEnd() {
  if (AtEnd()) {
    if (!unit_used_) RefuseUnit("a unit does not belong here; expected the end of the line");
    return;
  }
  throw SceneError(Here(), "found '" + tokens_[next_].text + "'; expected the end of the line");
}

void SceneReader::Expect(const std::string& text) {
  const std::string found = AtEnd() ? "the end of the line" : "'" + tokens_[next_].text + "'";
  if (!Accept(text)) throw SceneError(Here(), "found " + found + "; expected '" + text + "'");
}

Place SceneReader::Here() const {
  Place place = place_;
  place.column = AtEnd() ? static_cast<int>(line_length_) + 1 : tokens_[next_].column;
  return place;
}

Place SceneReader::LineStart() const {
  Place place = place_;
  place.column = tokens_.empty() ? 1 : tokens_[0].column;
  return place;
}

Place SceneReader::Last() const {
  Place place = place_;
  place.column = next_ == 0 ? 1 : tokens_[next_ - 1].column;
  return place;
}

void SceneReader::FailUnknown(const std::string& what,
                              const std::vector<std::string>& known) const {
  const std::string& found = tokens_[next_ - 1].text;
  std::string message = "'" + found + "' is no " + what;
  if (const std::string* nearest = NearestName(found, known)) {
    message += "; did you mean '" + *nearest + "'?";
  } else {
    message += "; there are ";
    for (size_t i = 0; i < known.size(); ++i) message += (i == 0 ? "" : ", ") + known[i];
  }
  FailLast(message);
}

}  // namespace vesper::cli
