// SPDX-License-Identifier: Apache-2.0
// The texts of docs/laws-as-text.md and of the README are right, and the mistake reads as shown.
#include <fstream>
#include <sstream>

#include "text_engine.hpp"

namespace vesper::test {
namespace {

std::string Page(const std::string& name) {
  std::ifstream file(VESPER_ROOT "/" + name);
  std::ostringstream page;
  page << file.rdbuf();
  return page.str();
}

/// Returns the blocks of a page that begin with this line.
std::vector<std::string> Blocks(const std::string& page, const std::string& first_line) {
  std::vector<std::string> blocks;
  for (size_t at = 0; (at = page.find("\n```" + first_line, at)) != std::string::npos;) {
    const size_t begin = page.find('\n', at + 1) + 1;
    const size_t end = page.find("\n```", begin);
    blocks.push_back(page.substr(begin, end + 1 - begin));
    at = end + 4;
  }
  return blocks;
}

TEST(DocumentsTest, TheirTextsAreRight) {
  const auto texts = Blocks(Page("docs/laws-as-text.md"), "law title=");
  EXPECT_EQ(texts.size(), 3u);
  for (const std::string& text : texts) EXPECT_EQ(ReportOn(text), "");
  const auto readme = Blocks(Page("README.md"), "law");
  ASSERT_EQ(readme.size(), 1u);
  EXPECT_EQ(readme[0], texts[0]);
}

// `reve control` indents all lines of a refusal but the first.
TEST(DocumentsTest, TheMistakeReadsAsShown) {
  const std::string page = Page("docs/laws-as-text.md");
  std::string text = Blocks(page, "law title=wind.law").at(0);
  const std::string right = "c (w - velocity)";
  text.replace(text.find(right), right.size(), "c w - velocity");
  std::string report = ReportOn(text);
  report.replace(report.find("x.law"), 5, "wind.law");
  for (size_t end = report.find('\n'); end + 1 < report.size(); end = report.find('\n', end + 1)) {
    report.insert(end + 1, "  ");
  }
  EXPECT_EQ(report, Blocks(page, "text title=mistake").at(0));
}

}  // namespace
}  // namespace vesper::test
