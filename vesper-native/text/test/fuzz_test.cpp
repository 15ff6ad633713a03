// SPDX-License-Identifier: Apache-2.0
// Random and hostile texts: each is refused or compiled after bounded work, and nothing crashes.
// VESPER_FUZZ_TEXTS sets the number of texts.
#include <pthread.h>

#include <algorithm>
#include <cstdlib>
#include <new>
#include <random>

#include "text_engine.hpp"

namespace {

// Allocations of this thread. They measure the work for a text, and do not depend on the machine.
thread_local uint64_t fuzz_allocations = 0;

}  // namespace

// The engine's library uses these operators, too.
[[gnu::noinline]] void* operator new(size_t size) {
  ++fuzz_allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept { std::free(memory); }

namespace vesper::test {
namespace {

/// Maximum number of allocations for a text: one for each byte, and those for the messages.
uint64_t MostAllocations(const std::string& text) { return 2000 + text.size(); }

/// Returns the report about a text, and expects that the work for it is bounded.
std::string BoundedReportOn(const std::string& text) {
  const uint64_t before = fuzz_allocations;
  std::string report = ReportOn(text);
  const uint64_t work = fuzz_allocations - before;
  EXPECT_GT(work, 0u) << "the engine's allocations are not counted";
  EXPECT_LE(work, MostAllocations(text)) << text.substr(0, 200);
  return report;
}

constexpr const char* kWords[] = {
    "law",         "x",         "each",   "body",       "pair",    "of",         "bodies",
    "within",      "r",         "apart",  "along",      "n",       "spring",     "from",
    "to",          "a",         "b",      "force",      "energy",  "mass",       "velocity",
    "position",    "gravity",   "let",    "if",         "else",    "and",        "or",
    "not",         "parameter", "phase",  "integrate",  "stages",  "at",         "stage",
    "has",         "may",       "have",   "in",         "vector",  "sqrt",       "sin",
    "min",         "dot",       "cross",  "1",          "2.5",     "1e308",      "0",
    "3 N",         "1 m",       "2 kg/s", "dt",         "time",    "(",          ")",
    "|",           ",",         ":",      ";",          "=",       "+=",         "-=",
    "+",           "-",         "*",      "/",          "^",       "·",          "×",
    "²",           "√",         "<",      ">",          ".",       "\"doc\"",    "#",
    "\n",          "\n  ",      "\n    ", "\n      ",   " ",       "attraction", "repulsion",
    "orientation", "rotate",    "exp",    "\t",         "surface", "vertices",   "σ",
    "½",           "length",    "world",  "energy cut", "%"};

std::string RandomText(std::mt19937& random) {
  std::string text = random() % 4 == 0 ? "" : "law x\n  each body:\n    ";
  const size_t words = random() % 60;
  for (size_t i = 0; i < words; ++i) {
    text += kWords[random() % std::size(kWords)];
    if (random() % 3 != 0) text += ' ';
  }
  return text;
}

/// Changes some bytes of a valid text.
std::string Damaged(std::mt19937& random) {
  static const std::string kRight =
      "law a \"Doc.\"\n  parameter k = 3 N/m, from 0 to 9 N/m\n  each body has heat in J, from 0 J "
      "to 9 kJ, q in W\n"
      "  each pair of bodies within 2.5 m, r apart along n:\n"
      "    energy = 4 J ((1 m/r)^12 - (1 m/r)^6)\n"
      "  each spring from a to b:\n    let q = k |a.position - b.position|\n"
      "    if q > 1 N: attraction = q\n    else: repulsion = 2 N\n"
      "  each body:\n    force -= dragCoefficient |velocity| velocity\n    heat = 0\n";
  std::string text = kRight;
  for (size_t changes = 1 + random() % 4; changes > 0; --changes) {
    const size_t at = random() % text.size();
    switch (random() % 3) {
      case 0:
        text[at] = static_cast<char>(random());
        break;
      case 1:
        text.erase(at, 1 + random() % 5);
        break;
      default:
        text.insert(at, kWords[random() % std::size(kWords)]);
        break;
    }
  }
  return text;
}

std::string Repeated(const std::string& part, size_t times) {
  std::string text;
  for (size_t i = 0; i < times; ++i) text += part;
  return text;
}

TEST(FuzzTextTest, RandomTextsCrashNothing) {
  const char* wanted = std::getenv("VESPER_FUZZ_TEXTS");
  const int texts = wanted != nullptr ? std::atoi(wanted) : 3000;
  std::mt19937 random(20260);
  for (int i = 0; i < texts; ++i) {
    const std::string text = i % 2 == 0 ? RandomText(random) : Damaged(random);
    if (!BoundedReportOn(text).empty()) continue;
    // The text is valid, so it must run. A value that is not finite may be a fault, but not a
    // crash.
    TestEngine engine;
    Bodies bodies(4);
    engine.AddBodies(bodies);
    vesper_library_id id = 0;
    if (TryLoadText(engine, text, id).status == VESPER_OK) engine.Advance(0.1, 2);
  }
}

/// Returns `count` different names, separated by commas. Each is followed by `behind`.
std::string Numbered(const std::string& name, size_t count, const std::string& behind = "") {
  std::string names;
  for (size_t i = 0; i < count; ++i) {
    names += (i == 0 ? "" : ", ") + name + std::to_string(i) + behind;
  }
  return names;
}

/// Returns a text with `depth` nested blocks `if`.
std::string NestedIf(size_t depth) {
  std::string text = "law x\n  each body:\n", indent = "    ";
  for (size_t i = 0; i < depth; ++i, indent += ' ') text += indent + "if mass > 1 kg:\n";
  return text + indent + "force.x += 1 N\n";
}

/// Returns a text with a chain of `depth` times `else if`.
std::string ElseIf(size_t depth) {
  std::string text = "law x\n  each body:\n    if mass > 0 kg: force.x += 1 N\n";
  for (size_t i = 0; i < depth; ++i) text += "    else if mass > 0 kg: force.x += 1 N\n";
  return text;
}

TEST(FuzzTextTest, HostileTextsAreRefusedAfterBoundedWork) {
  const std::string begin = "law x\n  each body:\n    ";
  const std::string add = begin + "force.x += ";
  const std::vector<std::string> texts = {
      // nesting and length
      begin + "force += " + Repeated("(", 30000),
      begin + "force += " + Repeated("-", 30000) + "1",
      begin + "force += " + Repeated("not ", 10000),
      begin + "force += " + Repeated("|", 30000),
      begin + "force += " + Repeated("√", 10000) + "2",
      begin + "force += mass" + Repeated("^2", 10000),
      begin + "force += mass" + Repeated("+mass", 10000),
      begin + "force += mass" + Repeated(" mass", 10000),
      begin + "force += mass" + Repeated(".x", 10000),
      begin + "force += " + Repeated("1 if 1<2 else ", 3000) + "2",
      add + Repeated("(1 N if 1 < ", 60) + "2" + Repeated(" else 1 N)", 60),
      add + Repeated("sin(", 10000) + "1" + Repeated(")", 10000),
      add + Repeated("min(1 N, ", 3000) + "1 N" + Repeated(")", 3000),
      add + "1 N" + Repeated(" if 1 < 2 and 2 < 3 or not 3 < 4 else 1 N", 1400),
      add + "1 N if 1" + Repeated(" < 2", 15000) + " else 2 N",
      begin + "let v = " + Repeated("(1, 2, ", 9000),
      begin + Repeated("let a = 1\n    ", 4000),
      "law x\n" + Repeated("  parameter a = 1\n", 3000),
      "law x\n  each body has " + Repeated("a, ", 20000) + "a\n",
      // Each name is compared with all names before it, so there are not too many of them.
      "law x\n  each body has " + Numbered("a", 9000) + "\n  each body: force.x += 1 N\n",
      "law x\n  each body has " + Numbered("a", 201) + "\n  each body: force.x += 1 N\n",
      "law x\n  parameter " + Numbered("a", 5000, " = 1") + "\n  each body: force.x += 1 N\n",
      "law x\n  parameter " + Numbered("a", 201, " = 1") + "\n  each body: force.x += 1 N\n",
      Repeated("law x\n  each body:\n    force += 1 N\n", 1500),
      Repeated("\n", 60000),
      Repeated("# x\n", 15000),
      Repeated("\"", 60000),
      std::string(60000, '\0'),
      std::string(60000, '\xff'),
      Repeated(begin + "force.x += 1 N\n", 17),
      // conditions
      begin + Repeated("if mass > 0: ", 3000) + "force += 1 N",
      NestedIf(17),
      NestedIf(31),
      NestedIf(300),
      ElseIf(16),
      ElseIf(1500),
      begin + Repeated("else: ", 9000),
      begin + "if " + Repeated("not ", 9000) + "mass > 0: force.x += 1 N",
      // numbers
      add + "1" + std::string(60000, '0') + " N",
      add + "0." + std::string(60000, '0') + "1 N",
      add + "1e" + std::string(60000, '9') + " N",
      add + "1e-" + std::string(60000, '9') + " N",
      add + "1e309 N",
      add + "1e308 km*N/m*m",
      add + Repeated("1.", 30000),
      add + Repeated("1 ", 30000),
      add + "0x1p1023 N",
      add + "nan N",
      add + "inf N",
      add + "mass^1e300",
      add + "mass^-99999999999999999999",
      add + "1 " + Repeated("m", 60000),
      add + "1 m" + Repeated("/m", 20000),
      add + "1 m^99999999999",
      add + "1 m^-99999999999",
      add + "1 m" + Repeated("⁹", 20000),
      "law x\n  parameter k = 1" + Repeated("/9", 20000) + "\n",
      "law x\n  parameter k = 1 N, from -1e308 to -1e309\n",
      "law x\n  phase integrate, 99999999999999999999 stages\n",
      "law x\n  at stage 4294967296:\n    each body: velocity = 0\n",
      "law x\n  version " + std::string(60000, '1') + ".0.0\n",
      // names
      "law " + std::string(60000, 'a') + "\n  each body:\n    force.x += 1 N\n",
      "law x\n  parameter " + std::string(60000, 'a') + " = 1\n",
      "law x\n  each body has " + std::string(60000, 'a') + "\n",
      "law x\n  each " + std::string(60000, 'a') + ":\n    force.x += 1 N\n",
      begin + std::string(60000, 'a') + " = 1",
      add + std::string(60000, 'a'),
      add + Repeated("σ", 30000),
      add + Repeated("a_", 30000) + "(1)",
      add + "m\u0430ss",     // a Cyrillic letter
      add + "mass\u0301",    // a combining accent
      add + "\u200bmass",    // a space of no width
      add + "\u202emass",    // from right to left
      add + "\U0001F600",    // an emoji
      add + "\xc3\x28",      // no UTF-8
      add + "\xed\xa0\x80",  // half of a surrogate pair
      begin + "let let = 1",
      begin + "let each = 1",
      begin + "let dt = 1",
      begin + "let sin = 1",
      "law each\n  each body:\n    force.x += 1 N\n",
      "law x\n  parameter energy = 1\n  each body:\n    force.x += energy * 1 N\n",
      "law x\n  each pair sin and cos of bodies:\n    attraction = 1 N\n",
      "law x\n  each pair a and a of bodies:\n    attraction = 1 N\n",
  };
  for (const std::string& text : texts) {
    const std::string report = BoundedReportOn(text);
    EXPECT_TRUE(report.starts_with("x.law:")) << text.substr(0, 100) << "\n" << report;
    EXPECT_LE(report.size(), 32767u);
    TestEngine engine;
    vesper_library_id id = 0;
    EXPECT_REFUSED(LIBRARY_LOAD_FAILED, "x.law:", TryLoadText(engine, text, id));
  }
}

/// Texts at the limits are valid, so the limits above are where they should be.
TEST(FuzzTextTest, LargeTextsAreAcceptedAfterBoundedWork) {
  const std::string begin = "law x\n  each body:\n    ";
  const std::vector<std::string> texts = {
      NestedIf(16),
      ElseIf(15),
      "law x\n  each body has " + Numbered("a", 200) + "\n  each body: force.x += 1 N\n",
      "law x\n  parameter " + Numbered("a", 200, " = 1") + "\n  each body: force.x += 1 N\n",
      begin + Repeated("if mass > 1 kg:\n      force.x += 1 N\n    ", 400),
      begin + Repeated("force.x += 1 N; ", 900),
      begin + "force.x += 1 N" + Repeated(" * 1", 250),
      begin + "force.x += " + Repeated("(", 15) + "1 N" + Repeated(")", 15),
      begin + "let " + std::string(3000, 'a') + " = 1\n    force.x += 1 N\n",
      begin + "force.x += 1e308 N * 1e-308 * 1e308 / 1e308",
      Repeated("\n", 60000) + begin + "force.x += 1 N\n",
  };
  for (const std::string& text : texts) {
    EXPECT_EQ(BoundedReportOn(text), "") << text.substr(0, 100);
    TestEngine engine;
    Bodies bodies(3);
    engine.AddBodies(bodies);
    LoadText(engine, text);
    EXPECT_OK(engine.Advance(0.1, 1));
  }
}

TEST(FuzzTextTest, FormulasThatDoubleWithEachLineAreLimited) {
  // The size of the expanded formulas doubles with each line, because each name is used twice.
  std::string doubling = "law x\n  each body:\n    let v0 = position.x / 1 m\n";
  std::string choosing = doubling;
  for (int i = 1; i < 60; ++i) {
    const std::string now = "v" + std::to_string(i), last = "v" + std::to_string(i - 1);
    doubling += "    let " + now + " = sin(" + last + ") * " + last + "\n";
    choosing += "    let " + now + " = (" + last + " if " + last + " < 1 else sin(" + last + "))\n";
  }
  EXPECT_EQ(BoundedReportOn(doubling + "    energy = 1 J * v59\n"), "");
  const std::string report = BoundedReportOn(choosing + "    energy = 1 J * v59\n");
  EXPECT_NE(report.find("too large"), std::string::npos) << report;
}

TEST(FuzzTextTest, TextsNeedLittleStack) {
  const std::vector<std::string> texts = {
      "law x\n  parameter p = 1 " + Repeated("m/(", 21000),
      "law x\n  each body has y in " + Repeated("m/(", 21000),
      "law x\n  each body:\n    force += 1 " + Repeated("m/(", 21000),
  };
  pthread_attr_t small;
  pthread_attr_init(&small);
  pthread_attr_setstacksize(&small, 1 << 20);  // as in a JVM
  for (const std::string& text : texts) {
    const auto report = [](void* of) -> void* {
      EXPECT_NE(ReportOn(*static_cast<const std::string*>(of)), "");
      return nullptr;
    };
    pthread_t thread;
    ASSERT_EQ(pthread_create(&thread, &small, report, const_cast<std::string*>(&text)), 0);
    pthread_join(thread, nullptr);
  }
  pthread_attr_destroy(&small);
}

TEST(FuzzTextTest, LetsOfALawTimesItsBlocksAreLimited) {
  std::string lets = "law x\n";
  for (int i = 0; i < 900; ++i) lets += "  let a" + std::to_string(i) + " = 0\n";
  EXPECT_NE(ReportOn(lets + Repeated("  each body:\n    force += 0 N\n", 900))
                .find("more than 2000 times"),
            std::string::npos);
  EXPECT_NE(ReportOn(lets + lets.substr(6)).find("more than 1000 lets"), std::string::npos);
}

TEST(FuzzTextTest, ControlCharactersAreRefusedByPlace) {
  const std::string report = ReportOn("law x \"\x1b[2J\"\n  each body:\n    force += 0 N\n");
  EXPECT_NE(report.find("x.law:1:8: the text contains the control character 0x1b"),
            std::string::npos)
      << report;
  EXPECT_EQ(report.find('\x1b'), std::string::npos);
}

TEST(FuzzTextTest, TheSignOfTheOhmIsAUnit) {
  EXPECT_EQ(ReportOn("law x\n  parameter R = 5 \u03a9\n  each body:\n"
                     "    force.x += R / (5 \u03a9) * 1 N\n"),
            "");
  EXPECT_NE(ReportOn("law x\n  each body has y in \u03a9"), "");
}

}  // namespace
}  // namespace vesper::test
