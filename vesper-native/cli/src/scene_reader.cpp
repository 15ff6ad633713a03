#include "scene_reader.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "nearest_name.hpp"

namespace vesper::cli {
namespace {

constexpr double kLargestCount = 1e9;

}  // namespace

SceneReader::SceneReader(std::string text, std::string file)
    : text_(std::move(text)), place_{std::move(file), 0, 1} {}

bool SceneReader::NextLine() {
  next_ = 0;
  tokens_.clear();
  while (tokens_.empty() && at_ < text_.size()) {
    const size_t end = std::min(text_.find('\n', at_), text_.size());
    ++place_.line;
    line_length_ = end - at_;
    tokens_ = Tokenize(std::string_view(text_).substr(at_, line_length_), place_);
    at_ = end + 1;
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

uint64_t SceneReader::Count(const std::string& what, uint64_t minimum) {
  const double number = Number(what);
  if (number != std::floor(number) || number < static_cast<double>(minimum) ||
      number > kLargestCount) {
    FailLast("expected " + what + ", a whole number from " + std::to_string(minimum) + " to 1e9");
  }
  return static_cast<uint64_t>(number);
}

Value SceneReader::ReadValue(const std::string& what) {
  if (!Accept("(")) return {Number(what)};
  Value value;
  while (!Accept(")")) {
    if (AtEnd()) throw SceneError(Here(), "'(' without its ')'");
    value.push_back(Number(what));
  }
  return value;
}

void SceneReader::ExpectEnd() {
  if (AtEnd()) return;
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
