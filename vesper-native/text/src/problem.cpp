// SPDX-License-Identifier: Apache-2.0
#include "problem.hpp"

#include <algorithm>

namespace vesper::text {
namespace {

bool BeginsCharacter(char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }

size_t Characters(std::string_view text) {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), BeginsCharacter));
}

std::string Located(std::string_view source, Place place) {
  return std::string(source) + ":" + std::to_string(place.line) + ":" +
         std::to_string(place.column) + ": ";
}

std::string_view LineAt(std::string_view text, uint32_t offset) {
  const size_t at = std::min<size_t>(offset, text.size());
  const size_t before = at == 0 ? std::string_view::npos : text.rfind('\n', at - 1);
  const size_t begin = before == std::string_view::npos ? 0 : before + 1;
  size_t end = std::min(text.find('\n', begin), text.size());
  if (end > begin && text[end - 1] == '\r') --end;
  return text.substr(begin, end - begin);
}

/// Replaces control characters, which would damage the layout of the report.
std::string Printable(std::string_view line) {
  std::string printable(line);
  for (char& c : printable) {
    if (static_cast<unsigned char>(c) < ' ' || c == 0x7f) c = ' ';
  }
  return printable;
}

}  // namespace

Place PlaceOf(std::string_view text, uint32_t offset) {
  const std::string_view before = text.substr(0, std::min<size_t>(offset, text.size()));
  const size_t line = before.rfind('\n');
  const size_t begin = line == std::string_view::npos ? 0 : line + 1;
  return {static_cast<uint32_t>(std::count(before.begin(), before.end(), '\n') + 1),
          static_cast<uint32_t>(Characters(before.substr(begin)) + 1)};
}

std::string Located(std::string_view source, std::string_view text, Span span) {
  return Located(source, PlaceOf(text, span.begin));
}

std::string QuotedPart(std::string_view text, Span span) {
  std::string part(text.substr(span.begin, span.end - span.begin));
  if (part.size() > 40) part = part.substr(0, 37) + "...";
  return "'" + part + "'";
}

void Problems::Add(Span span, const std::string& message, const std::string& hint) {
  if (full()) return;
  const bool known = std::any_of(problems_.begin(), problems_.end(), [&](const Problem& problem) {
    return problem.span.begin == span.begin && problem.message == message;
  });
  if (!known) problems_.push_back({span, Printable(message), Printable(hint)});
}

void Problems::Fail(Span span, std::string message, std::string hint) {
  Add(span, std::move(message), std::move(hint));
  throw Abandon{};
}

std::string Problems::FirstLine(std::string_view source, std::string_view text) const {
  const auto first = std::min_element(
      problems_.begin(), problems_.end(),
      [](const Problem& a, const Problem& b) { return a.span.begin < b.span.begin; });
  if (first == problems_.end()) return {};
  return Located(source, PlaceOf(text, first->span.begin)) + first->message +
         (first->hint.empty() ? "" : "; " + first->hint);
}

std::string Problems::Report(std::string_view source, std::string_view text) const {
  std::vector<Problem> ordered = problems_;
  std::stable_sort(ordered.begin(), ordered.end(),
                   [](const Problem& a, const Problem& b) { return a.span.begin < b.span.begin; });
  std::string report;
  for (const Problem& problem : ordered) {
    const Place place = PlaceOf(text, problem.span.begin);
    const std::string_view line = LineAt(text, problem.span.begin);
    const size_t begin =
        std::min<size_t>(static_cast<size_t>(line.data() - text.data()), text.size());
    const size_t end = std::min<size_t>(problem.span.end, begin + line.size());
    const size_t marked =
        end > problem.span.begin
            ? Characters(text.substr(problem.span.begin, end - problem.span.begin))
            : 1;
    report += Located(source, place) + problem.message + "\n";
    report += "  " + Printable(line) + "\n";
    report += "  " + std::string(place.column - 1, ' ') + "^" +
              std::string(std::max<size_t>(marked, 1) - 1, '~') + "\n";
    if (!problem.hint.empty()) report += "  " + problem.hint + "\n";
  }
  return report;
}

}  // namespace vesper::text
