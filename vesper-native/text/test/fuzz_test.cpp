// SPDX-License-Identifier: Apache-2.0
// Random and hostile texts: each is refused or compiled after bounded work, and nothing crashes.
// VESPER_FUZZ_TEXTS sets the number of texts.
#include <pthread.h>

#include <cstdlib>
#include <random>

#include "text_engine.hpp"

namespace vesper::test {
namespace {

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
      "law a \"Doc.\"\n  parameter k = 3 N/m, from 0 to 9 N/m\n  each body has heat in J\n"
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
    if (!ReportOn(text).empty()) continue;
    // The text is valid, so it must run. A value that is not finite may be a fault, but not a
    // crash.
    TestEngine engine;
    Bodies bodies(4);
    engine.AddBodies(bodies);
    vesper_library_id id = 0;
    if (TryLoadText(engine, text, id).status == VESPER_OK) engine.Advance(0.1, 2);
  }
}

TEST(FuzzTextTest, HostileTextsEndSoon) {
  const std::string begin = "law x\n  each body:\n    ";
  const std::vector<std::string> texts = {
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
      begin + Repeated("if mass > 0: ", 3000) + "force += 1 N",
      begin + Repeated("let a = 1\n    ", 4000),
      begin + Repeated("if mass > 1 kg:\n      force.x += 1 N\n    ", 900),
      "law x\n" + Repeated("  parameter a = 1\n", 3000),
      Repeated("law x\n  each body:\n    force += 1 N\n", 1500),
      Repeated("\n", 60000),
      Repeated("# x\n", 15000),
      Repeated("\"", 60000),
      std::string(60000, '\0'),
      std::string(60000, '\xff'),
      begin + "force += 1" + std::string(60000, '0') + " N",
      begin + "force += 1 " + Repeated("m", 60000),
      begin + "force += 1 m" + Repeated("/m", 20000),
      begin + "force += 1 m^99999999999",
  };
  for (const std::string& text : texts) ReportOn(text);
  // Doubling chains: each name is used twice.
  std::string doubling = "law x\n  each body:\n    let v0 = position.x / 1 m\n";
  std::string choosing = doubling;
  for (int i = 1; i < 60; ++i) {
    const std::string now = "v" + std::to_string(i), last = "v" + std::to_string(i - 1);
    doubling += "    let " + now + " = sin(" + last + ") * " + last + "\n";
    choosing += "    let " + now + " = (" + last + " if " + last + " < 1 else sin(" + last + "))\n";
  }
  ReportOn(doubling + "    energy = 1 J * v59\n");
  const std::string report = ReportOn(choosing + "    energy = 1 J * v59\n");
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
