// SPDX-License-Identifier: Apache-2.0
// Tests whether a law is compatible with an engine: names, types, units, access, conflicts,
// parameters.
#include <cmath>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

class MatchingTest : public testing::Test {
 protected:
  MatchingTest() { engine.AddBodies(bodies); }

  Bodies bodies{2};
  TestEngine engine;
};

TEST_F(MatchingTest, UnknownPropertySuggestsTheNearest) {
  const vesper_error error = engine.TryLoad("asking_misspelt");
  EXPECT_REFUSED(NOT_FOUND, "law asking: prototype si-f64 has no property 'positon'", error);
  EXPECT_REFUSED(NOT_FOUND, "did you mean 'position'?", error);
  EXPECT_STREQ(error.property, "positon");
  EXPECT_EQ(error.law_index, 0u);
}

TEST_F(MatchingTest, MismatchesNameBothSides) {
  EXPECT_REFUSED(TYPE_MISMATCH, "law asking: property position: kind is spring, expected body",
                 engine.TryLoad("asking_kind"));
  EXPECT_REFUSED(TYPE_MISMATCH, "type is f32 x 3, expected f64 x 3", engine.TryLoad("asking_type"));
  EXPECT_REFUSED(TYPE_MISMATCH, "type is f64 x 4, expected f64 x 3",
                 engine.TryLoad("asking_components"));
  EXPECT_REFUSED(UNIT_MISMATCH, "unit is kg, expected m", engine.TryLoad("asking_unit"));
  EXPECT_REFUSED(UNIT_MISMATCH, "unit is percent = 0.01, expected 1",
                 engine.TryLoad("asking_integer_scale"));
  EXPECT_REFUSED(ACCESS_CONFLICT, "asks for READ_WRITE, but the prototype allows READ",
                 engine.TryLoad("asking_access"));
}

TEST_F(MatchingTest, SumCannotBeReadWhileItIsSummed) {
  EXPECT_REFUSED(ACCESS_CONFLICT, "externalForce: cannot be READ in phase FORCE",
                 engine.TryLoad("asking_sum"));
}

TEST_F(MatchingTest, OptionalPropertyMayBeMissing) {
  engine.Load("asking_unknown_optional");
  EXPECT_OK(engine.Advance(1, 1));
}

TEST_F(MatchingTest, OptionalPropertyMayBeUnbound) {
  engine.Load("asking_unbound_optional");
  EXPECT_OK(engine.Advance(1, 1));
  std::vector<double> charge(2);
  EXPECT_OK(engine.Add("charge", charge, 1));
  EXPECT_REFUSED(LAW_FAILED, "law asking: the property is there", engine.Advance(1, 1));
}

TEST_F(MatchingTest, RequiredPropertyMayBeAddedAfterLoading) {
  const vesper_library_id asking = engine.Load("asking_unbound");
  const vesper_error error = engine.Advance(1, 1);
  EXPECT_REFUSED(NOT_FOUND, "law asking: needs property charge, which is not bound", error);
  EXPECT_EQ(error.library_id, asking);
  EXPECT_STREQ(error.property, "charge");
  std::vector<double> charge(2);
  EXPECT_OK(engine.Add("charge", charge, 1));
  EXPECT_OK(engine.Advance(1, 1));
}

TEST_F(MatchingTest, LibraryOfAnotherPrecisionIsRefused) {
  TestEngine single({.prototype = "si-f32"});
  EXPECT_REFUSED(TYPE_MISMATCH, "library push has no law for f32", single.TryLoad("push"));
}

TEST_F(MatchingTest, LawForAnyPrecisionIsTaken) {
  TestEngine single({.prototype = "si-f32"});
  single.Load("throwing");
}

TEST_F(MatchingTest, TwoWritersOfOnePropertyInOnePhaseCollide) {
  engine.Load("trace_observe");
  const vesper_error error = engine.TryLoad("trace_observe_again");
  EXPECT_REFUSED(ACCESS_CONFLICT,
                 "laws trace_observe and trace_observe_again both write property orientation",
                 error);
  EXPECT_STREQ(error.property, "orientation");
  engine.Load("trace_constrain");
}

TEST_F(MatchingTest, TwoIntegratorsOfOnePropertyCollide) {
  engine.Load("euler");
  EXPECT_REFUSED(ACCESS_CONFLICT, "laws euler and euler_four_stages both integrate property",
                 engine.TryLoad("euler_four_stages"));
}

TEST_F(MatchingTest, IntegratorsAgreeOnTheNumberOfStages) {
  engine.Load("euler");
  EXPECT_REFUSED(ACCESS_CONFLICT, "integrator euler has 1 stages, but trace_integrate has 2",
                 engine.TryLoad("trace_integrate"));
}

TEST_F(MatchingTest, RefusedLawChangesNothing) {
  engine.Load("euler");
  EXPECT_OK(engine.Advance(1, 1));
  const uint64_t before = engine.StateHash();
  const vesper_library_id push = engine.Load("push");
  EXPECT_OK(engine.Unload(push));
  EXPECT_NE(engine.TryLoad("asking_unit").status, VESPER_OK);
  EXPECT_NE(engine.TryLoad("euler_four_stages").status, VESPER_OK);
  EXPECT_EQ(engine.StateHash(), before);
  EXPECT_GT(engine.Load("push"), push) << "ids are never reused";
}

TEST_F(MatchingTest, ParametersHaveDefaults) {
  engine.Load("push");
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.force[0], 1);
}

TEST_F(MatchingTest, ParametersAreCheckedByNameAndRange) {
  EXPECT_REFUSED(NOT_FOUND, "law push has no parameter 'farce'; did you mean 'force'?",
                 engine.TryLoad("push", {{"farce", 1}}));
  EXPECT_REFUSED(NOT_FOUND, "no parameter 'pull.force'",
                 engine.TryLoad("push", {{"pull.force", 1}}));
  EXPECT_REFUSED(ALREADY_EXISTS, "parameter 'push.force' is given twice",
                 engine.TryLoad("push", {{"force", 1}, {"push.force", 1}}));
  EXPECT_REFUSED(INVALID_ARGUMENT, "law misbehaving: parameter mode is -1, expected 0 to 1000",
                 engine.TryLoad("misbehaving", {{"mode", -1}}));
  for (const double bad : {double{NAN}, double{INFINITY}, -double{INFINITY}}) {
    EXPECT_REFUSED(INVALID_ARGUMENT, "law push: parameter force is",
                   engine.TryLoad("push", {{"force", bad}}));
  }
  EXPECT_OK(engine.TryLoad("push", {{"push.force", 8}}));
  EXPECT_OK(engine.Advance(1, 1));
  EXPECT_EQ(bodies.force[0], 8);
}

TEST_F(MatchingTest, ParameterOfSeveralLawsNeedsTheNameOfItsLaw) {
  EXPECT_REFUSED(INVALID_ARGUMENT, "parameter 'fail' is ambiguous: write first.fail or second.fail",
                 engine.TryLoad("suite", {{"fail", 0}}));
  EXPECT_OK(engine.TryLoad("suite", {{"first.fail", 0}, {"second.fail", 0}}));
}

}  // namespace
}  // namespace vesper::test
