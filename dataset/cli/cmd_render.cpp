#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "dataset/cli/commands.h"
#include "dataset/commands/render_samples.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/error.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"

namespace ohb {
namespace {

struct Options {
  commands::RenderJob job;
  std::string views = "1", subsurface = "walk", shading = "v1", sampling = "adaptive", quality = "reference";
  std::vector<std::string> points;
  renderer::ErrorGoal goal{0};
  bool tolerance_given = false;
};

/// The job with what its options say in words.
commands::RenderJob job_of(const Options& options, const CommonOptions& common) {
  commands::RenderJob job = options.job;
  for (const std::string& point : options.points)
    job.points.push_back(commands::parse_point_light(point, job.points.size()));
  job.views = commands::parse_views(options.views);
  if (options.goal.relative_error > 0) job.goal = options.goal;
  job.settings.adaptive = options.sampling == "adaptive";
  job.settings.subsurface = options.subsurface == "walk";
  job.settings.shading = options.shading == "v2" ? renderer::ShadingModel::kV2 : renderer::ShadingModel::kV1;
  job.settings.seed = common.seed;
  job.quality = options.quality == "auto"   ? renderer::Quality::kAuto
                : options.quality == "fast" ? renderer::Quality::kFast
                                            : renderer::Quality::kReference;
  if (job.quality != renderer::Quality::kAuto && options.tolerance_given)
    throw InputError("", "--tolerance", "needs --quality auto", "give both, or neither");
  return job;
}

void print_report(const commands::RenderReport& report, const std::string& output) {
  size_t done = 0;
  double seconds = 0;
  uint64_t paths = 0, rays = 0;
  for (const commands::RenderedView& view : report.views) {
    done += !view.was_there;
    seconds += view.statistics.seconds;
    paths += view.statistics.paths;
    rays += view.statistics.closest_hit_rays + view.statistics.shadow_rays + view.statistics.walk_segments;
  }
  std::printf("%s: %zu views rendered, %zu were there\n", output.c_str(), done, report.views.size() - done);
  if (done > 0 && seconds > 0)
    std::printf("%.1f s for the lights, %.2f million paths/s, %.2f million rays/s, loading %.1f s\n", seconds,
                1e-6 * static_cast<double>(paths) / seconds, 1e-6 * static_cast<double>(rays) / seconds,
                report.load_seconds);
  for (const commands::RenderedView& view : report.views)
    if (const renderer::RegionError* worst = view.error.worst())
      std::printf("view %d: %.0f paths a pixel, relative error %.3g (%s under %s)\n", view.view,
                  view.error.spp, worst->relative_error, worst->region.c_str(), worst->light.c_str());
}

int run_render(const Options& options, const CommonOptions& common) {
  const commands::RenderJob job = job_of(options, common);
  const commands::RenderReport report = commands::render_samples(job);
  if (common.json)
    std::printf("%s", read_file(job.output / "render.json").c_str());
  else
    print_report(report, job.output.string());
  return 0;
}

void add_view_options(CLI::App* command, const std::shared_ptr<Options>& options) {
  command->add_option("MODEL", options->job.model_folder, "folder that bake wrote")->required();
  command->add_option("--environment", options->job.environments,
                      "latitude-longitude map, linear; may be repeated");
  command->add_option("--point", options->points,
                      "point light x,y,z,I: cm, and irradiance at 1 m; may be repeated");
  command->add_option("--views", options->views, "N: all of N views around a turn; N:i,j,...: some of them")
      ->capture_default_str();
  command->add_option("--size", options->job.settings.size_px, "width and height in pixels")
      ->check(program::whole_within(1, 16384))
      ->capture_default_str();
}

void add_path_options(CLI::App* command, const std::shared_ptr<Options>& options) {
  CLI::Option* spp = command->add_option("--spp", options->job.settings.spp, "paths a pixel")
                         ->check(program::whole_within(1, 1 << 24))
                         ->capture_default_str();
  CLI::Option* error =
      command
          ->add_option(
              "--error", options->goal.relative_error,
              "instead of --spp: paths until the estimated relative error of every light's image, and "
              "of each class in it, is below this")
          ->check(program::number_within(1e-4, 1.0))
          ->excludes(spp);
  command->add_option("--max-spp", options->goal.max_spp, "paths a pixel at most with --error")
      ->check(program::whole_within(16, 1 << 24))
      ->needs(error)
      ->capture_default_str();
  command->add_option("--bounces", options->job.settings.max_bounces, "indirect bounces at most")
      ->check(program::whole_within(0, 1024))
      ->capture_default_str();
}

void add_shading_options(CLI::App* command, const std::shared_ptr<Options>& options) {
  command
      ->add_option("--model", options->shading,
                   "Principled BSDF: v1, of Blender 3.4; v2, of Blender 4.5, which keeps energy")
      ->check(CLI::IsMember({"v1", "v2"}))
      ->capture_default_str();
  command
      ->add_option("--subsurface", options->subsurface,
                   "walk: light scatters under the skin; diffuse: it does not, which is faster")
      ->check(CLI::IsMember({"walk", "diffuse"}))
      ->capture_default_str();
  command
      ->add_option(
          "--sampling", options->sampling,
          "adaptive: --spp is the mean, more where the noise is (unbiased, from 16 on); even: all the same")
      ->check(CLI::IsMember({"adaptive", "even"}))
      ->capture_default_str();
}

void add_quality_options(CLI::App* command, const std::shared_ptr<Options>& options) {
  command
      ->add_option(
          "--quality", options->quality,
          "reference: everything; auto: leaves out what pilot images show to change no light by more "
          "than --tolerance; fast: no subsurface, 1 bounce, environments of 256 px, maps of 1024 px")
      ->check(CLI::IsMember({"reference", "fast", "auto"}))
      ->capture_default_str();
  command
      ->add_option_function<double>(
          "--tolerance",
          [options](double tolerance) {
            options->job.tolerance = tolerance, options->tolerance_given = true;
          },
          "of --quality auto: root mean square change of a light's image, relative (default 0.02)")
      ->check(program::number_within(1e-4, 1.0));
}

}  // namespace

void add_render_command(CLI::App& app, Commands& commands) {
  CLI::App* command =
      app.add_subcommand("render", "Samples of a model: one EXR a view with mask, maps and every light");
  auto options = std::make_shared<Options>();
  add_view_options(command, options);
  add_path_options(command, options);
  add_shading_options(command, options);
  add_quality_options(command, options);
  command->add_option("-o,--output", options->job.output, "folder for the samples")->required();
  command->add_flag("--overwrite", options->job.overwrites,
                    "replace the views in that folder if they are of other settings (else they are refused)");
  add_common_options(*command, commands.common);
  add_seed_option(*command, commands.common);
  command->footer(program::help_footer(
      {"openhumanbrdf render model --environment studio.exr --environment sunset.exr --views 8 -o samples",
       "openhumanbrdf render model --point 100,220,200,5 --views 100:0,25 --size 256 --error 0.02 -o "
       "samples"},
      "An interrupted run goes on where it stopped when the same command is given again."));
  command->callback([options, &commands] {
    commands.run = [options, &commands] { return run_render(*options, commands.common); };
  });
}

}  // namespace ohb
