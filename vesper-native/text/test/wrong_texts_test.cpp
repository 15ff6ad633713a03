// SPDX-License-Identifier: Apache-2.0
// Wrong texts, each with the message that its author reads: wrong_texts.txt.
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "text_engine.hpp"
#include "unit_parser.hpp"

namespace vesper::test {
namespace {

struct WrongText {
  std::string text;
  std::string report;
};

/// Reads a file of texts and reports. Each text follows a line "====", and its report follows a
/// line "----".
std::vector<WrongText> WrongTexts() {
  std::ifstream file(VESPER_TEXT_TESTS "/wrong_texts.txt");
  std::vector<WrongText> texts;
  std::string* part = nullptr;
  for (std::string line; std::getline(file, line);) {
    if (line == "====") {
      texts.emplace_back();
      part = &texts.back().text;
    } else if (line == "----") {
      part = &texts.back().report;
    } else if (part != nullptr) {
      *part += line + "\n";
    }
  }
  return texts;
}

TEST(WrongTextsTest, EachIsRefusedWithItsMessage) {
  const std::vector<WrongText> texts = WrongTexts();
  EXPECT_GE(texts.size(), 200u);
  for (const WrongText& wrong : texts) EXPECT_EQ(ReportOn(wrong.text), wrong.report) << wrong.text;
}

TEST(WrongTextsTest, LoadingNamesTheFirstProblemAndChangesNothing) {
  for (const WrongText& wrong : WrongTexts()) {
    TestEngine engine;
    vesper_library_id id = 0;
    const vesper_error error = TryLoadText(engine, wrong.text, id);
    EXPECT_EQ(error.status, VESPER_LIBRARY_LOAD_FAILED) << wrong.text;
    const std::string message = error.message,
                      report = wrong.report.substr(0, wrong.report.find('\n'));
    EXPECT_TRUE(message.starts_with(report.substr(0, 120))) << message << "\n" << report;
    EXPECT_EQ(id, 0u);
  }
}

TEST(WrongTextsTest, EveryReportHasLineColumnAndMark) {
  for (const WrongText& wrong : WrongTexts()) {
    std::istringstream lines(wrong.report);
    std::string first, line, mark;
    std::getline(lines, first);
    std::getline(lines, line);
    std::getline(lines, mark);
    unsigned row = 0, column = 0;
    ASSERT_EQ(std::sscanf(first.c_str(), "x.law:%u:%u: ", &row, &column), 2) << first;
    EXPECT_EQ(mark.find('^'), column + 1) << wrong.report;
  }
}

/// Returns the number of units that a message names, such as 2 for "'mass' is kg (a mass), but
/// 'force' is N (a force)". A plain number counts as a unit.
size_t UnitsIn(const std::string& message) {
  static const std::regex kUnit("(?:is|in|found) (?:a vector in |a vector of )?([^ ,:]+)");
  size_t units = 0;
  for (std::sregex_iterator at(message.begin(), message.end(), kUnit), end; at != end; ++at) {
    const std::string word = (*at)[1];
    if (word == "a" || word == "an" || word == "in") continue;
    try {
      ParseUnitOrThrowWhere(word);
      ++units;
    } catch (const UnitError&) {
    }
  }
  static const std::regex kPlain("plain number");
  return units +
         static_cast<size_t>(std::distance(
             std::sregex_iterator(message.begin(), message.end(), kPlain), std::sregex_iterator()));
}

TEST(WrongTextsTest, AProblemThatNamesTwoUnitsSaysWhatWouldMakeItRight) {
  EXPECT_EQ(UnitsIn("x.law:3:14: 'velocity' is a vector in m/s (a velocity), but 'f' is N"), 2u);
  EXPECT_EQ(UnitsIn("x.law:3:14: the exponent 't' is s (a time), expected a plain number"), 2u);
  EXPECT_EQ(UnitsIn("x.law:3:14: 'k' is in use already"), 0u);
  size_t checked = 0;
  for (const WrongText& wrong : WrongTexts()) {
    std::vector<std::string> lines;
    std::istringstream report(wrong.report);
    for (std::string line; std::getline(report, line);) lines.push_back(line);
    for (size_t i = 0; i < lines.size(); ++i) {
      if (!lines[i].starts_with("x.law:") || UnitsIn(lines[i]) < 2) continue;
      ++checked;
      // Message, line and mark are followed by the hint.
      EXPECT_TRUE(i + 3 < lines.size() && !lines[i + 3].starts_with("x.law:")) << wrong.report;
    }
  }
  EXPECT_GE(checked, 60u);
}

}  // namespace
}  // namespace vesper::test
