// SPDX-License-Identifier: Apache-2.0
// The texts of docs/laws-as-text.md and of the README are right, and the mistake reads as shown.
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "../src/syntax.hpp"
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
  EXPECT_EQ(texts.size(), 5u);
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

std::set<std::string> WordsOf(const std::string& text, const std::string& pattern) {
  const std::regex word(pattern);
  std::set<std::string> words;
  for (std::sregex_iterator at(text.begin(), text.end(), word), end; at != end; ++at) {
    words.insert((*at)[1]);
  }
  return words;
}

/// Words of the grammar that belong to names of rules, remarks and examples.
const std::set<std::string> kOtherWords = {
    "text",  "block", "blocks",   "heading",  "statement", "statements", "then", "indented",
    "lines", "line",  "same",     "memory",   "own",       "world",      "it",   "without",
    "rows",  "that",  "refer",    "others",   "an",        "integrator", "doc",  "the",
    "names", "mass",  "velocity", "function", "position"};

/// Returns the words that the parser takes or expects, found in its source.
std::set<std::string> WordsOfTheParser() {
  std::set<std::string> words;
  for (const char* file : {"parser.cpp", "expression_parser.cpp"}) {
    words.merge(WordsOf(Page(std::string("vesper-native/text/src/") + file),
                        "(?:Takes|Expect|Is)\\(\"([a-z]{2,})\""));
  }
  // The parser recognizes loops of other languages to explain that there are none.
  for (const char* foreign : {"for", "while"}) EXPECT_EQ(words.erase(foreign), 1u) << foreign;
  for (const char* phase : {"force", "integrate", "constrain", "observe"}) {
    EXPECT_EQ(ReportOn(std::string("law x\n  phase ") + phase +
                       "\n  each body has y\n  each body: y = 1\n"),
              "");
    words.insert(phase);
  }
  for (const char* target : {"energy", "attraction", "repulsion"}) {
    EXPECT_EQ(ReportOn(std::string("law x\n  each pair of bodies, r apart: ") + target +
                       " = 1 N/m^2 r^2" + (target[0] == 'e' ? " * 1 m\n" : "\n")),
              "");
    words.insert(target);
  }
  return words;
}

TEST(DocumentsTest, TheGrammarHasTheWordsOfTheParserAndNoOthers) {
  const std::string grammar = Blocks(Page("docs/laws-as-text.md"), "text title=grammar").at(0);
  std::set<std::string> page = WordsOf(grammar, "([A-Za-z]{2,})");
  std::erase_if(page, [](const std::string& word) { return word[0] < 'a'; });
  for (const std::string& other : kOtherWords) {
    EXPECT_EQ(page.erase(other), 1u) << other;
    EXPECT_FALSE(text::IsReserved(other)) << other;
  }
  EXPECT_EQ(page, WordsOfTheParser());
  for (const std::string& word : page) {
    const std::string report =
        ReportOn("law x\n  each body:\n    let " + word + " = 3 N\n    force.x += 1 N\n");
    const bool is_refused = report.find("is a word of the language") != std::string::npos;
    EXPECT_EQ(is_refused, text::IsReserved(word)) << report;
  }
}

TEST(DocumentsTest, TheListOfFunctionsIsThatOfTheParser) {
  const std::string page = Page("docs/laws-as-text.md");
  const size_t begin = page.find("- **Functions** of numbers are ");
  ASSERT_NE(begin, std::string::npos);
  std::string list = page.substr(begin, page.find("\n- **", begin + 1) - begin);
  list = std::regex_replace(list, std::regex("\\([^)]*\\)"), "");
  std::set<std::string> named = WordsOf(list, "([a-z][a-z0-9]+)");
  for (const char* other : {"of", "numbers", "are", "and", "vectors"}) {
    EXPECT_EQ(named.erase(other), 1u) << other;
  }
  named.erase("unctions");
  const auto functions = text::FunctionNames();
  EXPECT_EQ(named, std::set<std::string>(functions.begin(), functions.end()));
}

}  // namespace
}  // namespace vesper::test
