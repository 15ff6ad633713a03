// SPDX-License-Identifier: Apache-2.0
// What every law library promises, checked on every library in a folder: the law test kit, and the
// README that users read.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string_view>

#include "vesper/kit/check.hpp"
#include "vesper/kit/law_file.hpp"

namespace vesper {
namespace {

std::string law_folder = VESPER_LAW_PATH;
std::string source_folder = VESPER_LAW_SOURCES;

std::vector<std::string> LawFiles() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(law_folder)) {
    if (!LawFile::NameOf(entry.path()).empty()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

struct Case {
  const Check* check;
  Subject subject;
};
void PrintTo(const Case& one, std::ostream* out) { *out << one.subject.file; }

/// Every check on every library, in both precisions where that matters. The check `time` measures,
/// and no law can fail it.
std::vector<Case> Cases() {
  std::vector<Case> cases;
  for (const std::string& file : LawFiles()) {
    for (const Check& check : Checks()) {
      if (check.name == std::string_view("time")) continue;
      if (!check.per_precision) {
        cases.push_back({&check, {file, 0}});
        continue;
      }
      cases.push_back({&check, {file, VESPER_F32}});
      cases.push_back({&check, {file, VESPER_F64}});
    }
  }
  return cases;
}

/// How long one check may take. The machine may be busy, and a law that is built with a sanitizer
/// can be a hundred times slower.
constexpr std::chrono::minutes kLimit{10};

class LawContract : public ::testing::TestWithParam<Case> {};

TEST_P(LawContract, Keeps) {
  const auto& [check, subject] = GetParam();
  const CheckOutcome outcome = RunCheck(*check, subject, kLimit);
  EXPECT_NE(outcome.verdict, Verdict::kFail) << check->promise << ": " << outcome.note;
}

TEST(CheckLimit, AnEndlessCheckFailsAfterItsProcessorTime) {
  const Check endless{"endless", "ends", false, [](const Subject&) -> std::string {
                        for (volatile unsigned i = 0;;) i = i + 1;
                      }};
  const CheckOutcome outcome = RunCheck(endless, {}, std::chrono::seconds(1));
  EXPECT_EQ(outcome.verdict, Verdict::kFail);
  EXPECT_EQ(outcome.note, "not done after 1 s of processor time");
}

class LawFileContract : public ::testing::TestWithParam<std::string> {
 protected:
  const std::string name_ = LawFile::NameOf(GetParam());
};

TEST_P(LawFileContract, ReadmeHasTheSectionsThatUsersNeed) {
  const std::string path = source_folder + "/" + name_ + "/README.md";
  std::ifstream file(path);
  ASSERT_TRUE(file) << path;
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  for (const char* section : {"Equation", "Properties", "Parameters", "Mass 0", "Limits"}) {
    EXPECT_NE(text.find("\n## " + std::string(section) + "\n"), std::string::npos) << section;
  }
  const LawFile library(GetParam());
  for (const vesper_law_desc* law : library.Laws(VESPER_F64)) {
    for (const auto& use : std::span(law->uses, law->use_count)) {
      EXPECT_NE(text.find("`" + std::string(use.name) + "`"), std::string::npos) << use.name;
    }
    for (const auto& parameter : std::span(law->parameters, law->parameter_count)) {
      EXPECT_NE(text.find("`" + std::string(parameter.name) + "`"), std::string::npos)
          << parameter.name;
    }
  }
}

/// Returns the law's name; a text beside a compiled law has another one.
std::string TestName(const std::string& file) {
  return LawFile::NameOf(file) + (file.ends_with(".law") ? "_text" : "");
}

std::string PrintFile(const ::testing::TestParamInfo<std::string>& info) {
  return TestName(info.param);
}

std::string PrintCase(const ::testing::TestParamInfo<Case>& info) {
  const auto& [check, subject] = info.param;
  std::string name = TestName(subject.file) + "_" + check->name;
  if (check->per_precision) name += subject.real_type == VESPER_F64 ? "_f64" : "_f32";
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Laws, LawFileContract, ::testing::ValuesIn(LawFiles()), PrintFile);
INSTANTIATE_TEST_SUITE_P(Laws, LawContract, ::testing::ValuesIn(Cases()), PrintCase);

}  // namespace
}  // namespace vesper

int main(int argc, char** argv) {
  std::vector<std::string> folders;
  for (const char* argument : std::span(argv + 1, argv + argc)) {
    if (argument[0] != '-') folders.push_back(argument);
  }
  if (folders.size() > 0) vesper::law_folder = folders[0];
  if (folders.size() > 1) vesper::source_folder = folders[1];
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
