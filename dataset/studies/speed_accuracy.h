// Error against time, of our renderer and of Cycles, on one view and one machine.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/model/environment.h"
#include "dataset/model/model.h"

namespace ohb::studies {

struct SpeedAccuracySettings {
  int size_px = 256, max_spp = 256, seeds = 4, max_bounces = 32;
  int threads = 0;  // 0: all
  uint64_t seed = 1;
  /// What reading our files takes, warm, as Cycles reads its own: counts as our loading. Each environment's.
  double model_read_s = 0, environment_read_s = 0;
  std::filesystem::path blender;  // empty: from PATH
};

/// One amount of work of one way to render. Times are wall seconds of one image (of all lights where the
/// series has several), loading apart; processor seconds are of all threads.
struct SpeedAccuracyPoint {
  std::string series;
  int spp = 0;
  double adaptive_threshold = 0;  // of Cycles' early stop; 0: none
  double load_s = 0, wall_s = 0, cpu_s = 0;
  double relative_error = 0;  // root of (mean squared error / mean square) over the subject's pixels
  bool on_front = false;      // nothing else is both faster (loading included) and nearer
};

/// Times to the error that our best image has: of Cycles, as it is fastest, over ours.
struct SpeedAccuracyRatio {
  std::string ours, cycles;
  double adaptive_threshold = 0;  // that Cycles is fastest with; 0: none
  double relative_error = 0;
  double with_loading = 0, without_loading = 0;
};

struct SpeedAccuracy {
  std::string model_name, blender_version;
  std::vector<std::string> environments;
  SpeedAccuracySettings settings;
  std::vector<SpeedAccuracyPoint> points;
  std::vector<SpeedAccuracyRatio> ratios;
  /// What leaving subsurface out changes: root mean square over the subject, relative; 0 if there is none.
  double subsurface_effect = 0;
};

/// Renders the front view with 4, 16, ... max_spp paths a pixel and `seeds` seeds each: ours (even and
/// adaptive budgets) and Cycles (with and without its adaptive stop), with and without subsurface (if the
/// model has any), and if there is more than one environment, all of them in one pass of ours against one
/// render each of Cycles. The first environment lights all else, among it ours with kAuto and kFast. The
/// error of unbiased images is the standard deviation over the seeds; that of others their distance to the
/// mean of the best of ours and of Cycles, less that mean's own. Loading is everything between the files and
/// the first ray. It is the least that any series took that loads the same (the first one finds cold caches),
/// and counts once for several lights; that of kAuto includes its choice. Throws InputError if Blender is
/// missing, wrong, or fails.
SpeedAccuracy measure_speed_accuracy(const Model& model, const std::vector<Environment>& environments,
                                     const SpeedAccuracySettings& settings,
                                     const std::filesystem::path& scratch);

/// One line a point, with a header; and everything.
std::string speed_accuracy_csv(const SpeedAccuracy& chart);
std::string speed_accuracy_json(const SpeedAccuracy& chart);

/// Draws chart.svg and chart.png in `folder`, and keeps chart.gp, which draws them anew. Throws InputError if
/// gnuplot is missing or fails.
void draw_speed_accuracy(const SpeedAccuracy& chart, const std::filesystem::path& folder);

}  // namespace ohb::studies
