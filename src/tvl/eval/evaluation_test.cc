#include "tvl/eval/evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tvl/base/check.h"
#include "tvl/eval/evaluation_text.h"
#include "tvl/eval/test_paths.h"

namespace tvl {
namespace {

TEST(Evaluation, MeansOverStretchesAndOverDrivesDiffer) {
  // 5 stretches of 100 m at 1.01 % and 15 + 5 stretches (100, 200 m) at 2.02 and 2.01 %.
  const std::vector<Rigid3d> a = ConstantMotion(150, 1.0, 0.0), b = ConstantMotion(251, 1.0, 0.0);
  const Evaluation evaluation =
      Combine({EvaluateDrive("a", a, Scaled(a, 1.01)), EvaluateDrive("b", b, Scaled(b, 1.02))});
  const double b_mean = (15 * 2.02 + 5 * 2.01) / 20.0;
  EXPECT_NEAR(evaluation.segment_mean.t_err_percent, (5 * 1.01 + 20 * b_mean) / 25.0, 1e-9);
  EXPECT_NEAR(evaluation.drive_mean.t_err_percent, (1.01 + b_mean) / 2.0, 1e-9);
  EXPECT_NEAR(evaluation.drives[0].truth_length_m, 149.0, 1e-9);
  EXPECT_NEAR(evaluation.drives[0].estimate_length_m, 1.01 * 149.0, 1e-9);
  EXPECT_NEAR(evaluation.drives[0].total.translation_m, 1.49, 1e-9);
}

TEST(Evaluation, RefusesWhatDoesNotPairUp) {
  const std::vector<Rigid3d> path = ConstantMotion(5, 1.0, 0.0);
  EXPECT_THROW(EvaluateDrive("x", path, ConstantMotion(4, 1.0, 0.0)), InputError);
  EXPECT_THROW(EvaluateDrive("x", {Rigid3d()}, {Rigid3d()}), InputError);
}

TEST(EvaluationText, JsonCarriesUnitsAndNullsForWhatIsNotKnown) {
  const std::vector<Rigid3d> path = ConstantMotion(50, 1.0, 0.0);
  const auto json =
      nlohmann::json::parse(ToJson(Combine({EvaluateDrive("x", path, Scaled(path, 1.02))})));
  EXPECT_TRUE(json["drives"][0]["kitti"]["t_err_percent"].is_null());
  EXPECT_NEAR(json["drives"][0]["total"]["translation_m"].get<double>(), 0.98, 1e-9);
  EXPECT_NEAR(json["drives"][0]["rpe_1_frame"]["translation_rmse_m"].get<double>(), 0.02, 1e-9);
  EXPECT_EQ(json["drives"][0]["rpe_10_m"]["count"], 39);
}

TEST(EvaluationText, TableNamesTheDrive) {
  const std::vector<Rigid3d> path = ConstantMotion(150, 1.0, 0.0);
  const std::string table = ToTable(Combine({EvaluateDrive("drive 7", path, Scaled(path, 1.01))}));
  EXPECT_THAT(table, testing::HasSubstr("drive 7: 150 frames, 149.00 m"));
  EXPECT_THAT(table, testing::HasSubstr("1.0100 %"));
}

}  // namespace
}  // namespace tvl
