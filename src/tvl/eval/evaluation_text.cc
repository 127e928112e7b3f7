#include "tvl/eval/evaluation_text.h"

#include <cstdio>
#include <nlohmann/json.hpp>

namespace tvl {
namespace {

using Json = nlohmann::ordered_json;

Json JsonOf(const KittiError& error) {
  const bool known = error.segments > 0;
  Json json;
  json["segments"] = error.segments;
  json["t_err_percent"] = known ? Json(error.t_err_percent) : Json();
  json["r_err_deg_per_m"] = known ? Json(error.r_err_deg_per_m) : Json();
  json["r_err_deg_per_100m"] = known ? Json(error.r_err_deg_per_100m()) : Json();
  return json;
}

Json JsonOf(const AbsoluteError& error) {
  return {{"rmse_m", error.rmse_m},
          {"mean_m", error.mean_m},
          {"median_m", error.median_m},
          {"max_m", error.max_m}};
}

Json JsonOf(const RelativeError& error) {
  const bool known = error.count > 0;
  Json json;
  json["count"] = error.count;
  json["translation_rmse_m"] = known ? Json(error.translation_rmse_m) : Json();
  json["rotation_rmse_deg"] = known ? Json(error.rotation_rmse_deg) : Json();
  return json;
}

Json JsonOf(const DriveEvaluation& drive) {
  Json json;
  json["name"] = drive.name;
  json["frames"] = drive.frames;
  json["truth_length_m"] = drive.truth_length_m;
  json["estimate_length_m"] = drive.estimate_length_m;
  json["kitti"] = JsonOf(drive.kitti);
  for (size_t i = 0; i < kKittiLengths_m.size(); ++i) {
    Json of_length = JsonOf(drive.kitti_by_length[i]);
    of_length["length_m"] = kKittiLengths_m[i];
    json["kitti_by_length"].push_back(of_length);
  }
  json["ate_se3"] = JsonOf(drive.ate);
  json["ate_first_pose"] = JsonOf(drive.ate_first_pose);
  json["rpe_1_frame"] = JsonOf(drive.rpe_frame);
  json["rpe_10_m"] = JsonOf(drive.rpe_10m);
  json["rpe_100_m"] = JsonOf(drive.rpe_100m);
  json["total"] = {{"translation_m", drive.total.translation_m},
                   {"rotation_deg", drive.total.rotation_deg}};
  return json;
}

// printf into a string; lines are short.
template <typename... Args>
std::string Format(const char* format, Args... args) {
  char buffer[256];
  std::snprintf(buffer, sizeof(buffer), format, args...);
  return buffer;
}

std::string KittiLine(const char* label, const KittiError& error) {
  if (error.segments == 0) return Format("  %-22s -  (no stretch of 100 m)\n", label);
  return Format("  %-22s %8.4f %%   %8.5f deg/m = %7.4f deg/100m   (%zu stretches)\n", label,
                error.t_err_percent, error.r_err_deg_per_m, error.r_err_deg_per_100m(),
                error.segments);
}

std::string AbsoluteLine(const char* label, const AbsoluteError& error) {
  return Format("  %-22s %8.4f m   mean %.4f, median %.4f, max %.4f m\n", label, error.rmse_m,
                error.mean_m, error.median_m, error.max_m);
}

std::string RelativeLine(const char* label, const RelativeError& error) {
  if (error.count == 0) return Format("  %-22s -  (drive too short)\n", label);
  return Format("  %-22s %8.4f m   %8.4f deg   (%zu stretches)\n", label, error.translation_rmse_m,
                error.rotation_rmse_deg, error.count);
}

std::string TableOf(const DriveEvaluation& drive) {
  std::string table =
      Format("%s: %zu frames, %.2f m driven (estimate %.2f m)\n", drive.name.c_str(), drive.frames,
             drive.truth_length_m, drive.estimate_length_m);
  table += KittiLine("KITTI t_err, r_err", drive.kitti);
  for (size_t i = 0; i < kKittiLengths_m.size(); ++i) {
    if (drive.kitti_by_length[i].segments == 0) continue;
    table +=
        KittiLine(Format("  over %.0f m", kKittiLengths_m[i]).c_str(), drive.kitti_by_length[i]);
  }
  table += AbsoluteLine("ATE rmse, aligned", drive.ate);
  table += AbsoluteLine("ATE rmse, first pose", drive.ate_first_pose);
  table += RelativeLine("RPE rmse, 1 frame", drive.rpe_frame);
  table += RelativeLine("RPE rmse, 10 m", drive.rpe_10m);
  table += RelativeLine("RPE rmse, 100 m", drive.rpe_100m);
  table += Format("  %-22s %8.4f m   %8.4f deg\n", "whole drive (Table 1)",
                  drive.total.translation_m, drive.total.rotation_deg);
  return table;
}

}  // namespace

std::string ToJson(const Evaluation& evaluation) {
  Json json;
  json["drives"] = Json::array();
  for (const DriveEvaluation& drive : evaluation.drives) json["drives"].push_back(JsonOf(drive));
  json["kitti_segment_mean"] = JsonOf(evaluation.segment_mean);
  json["kitti_drive_mean"] = JsonOf(evaluation.drive_mean);
  return json.dump(2) + "\n";
}

std::string ToTable(const Evaluation& evaluation) {
  std::string table;
  for (const DriveEvaluation& drive : evaluation.drives) table += TableOf(drive);
  if (evaluation.drives.size() > 1) {
    table += Format("all %zu drives\n", evaluation.drives.size());
    table += KittiLine("mean over stretches", evaluation.segment_mean);
    table += KittiLine("mean over drives", evaluation.drive_mean);
  }
  return table;
}

}  // namespace tvl
