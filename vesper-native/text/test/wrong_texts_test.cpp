// SPDX-License-Identifier: Apache-2.0
// Wrong texts, each with the message that its author reads: wrong_texts.txt.
#include <fstream>
#include <set>
#include <sstream>

#include "text_engine.hpp"

namespace vesper::test {
namespace {

struct WrongText {
  std::string text;
  std::string report;
};

/// Reads "====", a text, "----", its report, and so on.
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

}  // namespace
}  // namespace vesper::test
