// The page of a validation.
#include <fmt/format.h>

#include "renderer/validation/pictures.h"
#include "renderer/validation/report.h"
#include "renderer/validation/report_pictures.h"

namespace ohb::validation {
namespace {

constexpr const char* kStyle = R"(
body { font: 16px/1.5 system-ui, sans-serif; color: #222; background: #fcfcfc; max-width: 66rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 2.2rem; }
.verdict { border-left: .5rem solid; padding: .6rem 1rem; background: #fff; }
.pass { border-color: #2a7f3f; } .undecided { border-color: #c58a00; } .difference { border-color: #b2182b; }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(14rem, 1fr)); gap: 1rem; }
figure { margin: 0; } figure img { width: 100%; image-rendering: pixelated; border: 1px solid #ddd; background: #eee; }
figcaption { font-size: .9rem; color: #444; }
.scale { height: .8rem; border: 1px solid #ccc; } .ends { display: flex; justify-content: space-between; font-size: .85rem; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; font-size: .92rem; }
th, td { padding: .25rem .6rem; text-align: right; border-bottom: 1px solid #e3e3e3; } th:first-child, td:first-child { text-align: left; }
.bad { color: #b2182b; font-weight: 600; } .unsure { color: #8a6100; font-weight: 600; } .dim { color: #777; }
details { margin-top: 1rem; } summary { cursor: pointer; }
)";

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text)
    result += c == '&'   ? "&amp;"
              : c == '<' ? "&lt;"
              : c == '>' ? "&gt;"
              : c == '"' ? "&quot;"
                         : std::string(1, c);
  return result;
}

std::string percent(double value, int digits = 3) {
  return fmt::format("{:+.{}f} %", 100 * value, digits);
}

std::string css_gradient() {
  std::string stops;
  for (int i = 0; i <= 4; ++i) {
    const Vec3f colour = 255.0f * diverging_colour(0.5f * static_cast<float>(i) - 1);
    stops += fmt::format("{}rgb({:.0f},{:.0f},{:.0f})", i ? "," : "", colour.x, colour.y, colour.z);
  }
  return "linear-gradient(to right," + stops + ")";
}

std::string legend(const std::string& low, const std::string& high) {
  return fmt::format(
      "<div class=\"scale\" style=\"background:{}\"></div><div class=\"ends\"><span>{}</span>"
      "<span>0</span><span>{}</span></div>",
      css_gradient(), low, high);
}

std::string figure(const std::string& file, const std::string& alt, const std::string& caption,
                   const std::string& below = "") {
  return fmt::format("<figure><img src=\"{}\" alt=\"{}\">{}<figcaption>{}</figcaption></figure>\n", file,
                     escaped(alt), below, caption);
}

std::string verdict_block(const Validation& v) {
  const Outcome outcome = v.verdict.outcome;
  const char* name = outcome == Outcome::kPass        ? "pass"
                     : outcome == Outcome::kUndecided ? "undecided"
                                                      : "difference";
  std::string title = v.verdict.sentence + ".";
  title[0] = static_cast<char>(std::toupper(title[0]));
  std::string html = fmt::format("<div class=\"verdict {}\"><strong>{}</strong>", name, escaped(title));
  for (const std::string& reason : v.verdict.reasons) html += "<br>" + escaped(reason);
  return html + "</div>\n";
}

std::string picture_block(const Validation& v) {
  const ReportScales scales = report_scales(v);
  const std::string difference = fmt::format("{:g} %", 100 * scales.difference);
  std::string html = "<div class=\"pictures\">\n";
  html += figure("ours.png", "Our rendering, mean of all seeds", "Ours, mean of all seeds");
  html += figure("cycles.png", "Cycles' rendering, mean of all seeds",
                 "Cycles, mean of all seeds, same exposure");
  html += figure(
      "difference.png", "Map of the relative difference, blue where ours is darker, red where brighter",
      "Ours / Cycles - 1 in 3 x 3 px bins: blue is darker, red brighter than Cycles. Without bias it is "
      "noise of both colours.",
      legend("-" + difference, "+" + difference));
  html += figure(
      "z.png", "Map of the significance of the difference, in standard errors",
      "Z: the difference over its standard error (normal equivalent of Welch's t). Without bias 95 % of the "
      "bins are within 2.",
      legend(fmt::format("-{:g}", scales.z), fmt::format("+{:g}", scales.z)));
  return html + "</div>\n";
}

std::string region_row(const RegionResult& result, const ValidationThresholds& limits) {
  const RegionRatio& region = result.ratio;
  const bool judged = is_judged(region, limits) && region.name != "outline";
  const bool good = region.total.low >= 1 - limits.ratio && region.total.high <= 1 + limits.ratio;
  const bool is_outside = region.total.low > 1 + limits.ratio || region.total.high < 1 - limits.ratio;
  const char* look = !judged || good ? "" : is_outside ? "bad" : "unsure";
  std::string row =
      fmt::format("<tr><td>{}{}</td><td>{:.0f}</td><td>{} x {}</td><td>{} x {}</td>", escaped(region.name),
                  judged ? "" : " <span class=\"dim\">(not judged)</span>", region.weight_px,
                  result.work.seeds, result.work.our_spp, result.work.seeds, result.work.cycles_spp);
  row += fmt::format("<td class=\"{}\">{}</td><td>{} to {}</td>", look, percent(region.total.value - 1),
                     percent(region.total.low - 1), percent(region.total.high - 1));
  for (const Interval& channel : region.channel) row += "<td>" + percent(channel.value - 1) + "</td>";
  return row + "</tr>\n";
}

std::string region_table(const Validation& v) {
  const ValidationThresholds& limits = v.settings.thresholds;
  std::string html =
      "<table><tr><th>region</th><th>pixels</th><th>seeds x paths, ours</th><th>Cycles</th><th>ours / Cycles "
      "- 1</th>"
      "<th>95 % interval</th><th>red</th><th>green</th><th>blue</th></tr>\n";
  for (const RegionResult& region : v.regions) html += region_row(region, limits);
  html += region_row(v.band, limits);
  return html + fmt::format(
                    "</table><p>Means of radiance, weighted by each class's share of the pixel. The interval "
                    "comes from the spread over the independent seeds of each side; where {} x {} left it "
                    "too wide the region was rendered again, alone, with new seeds and as many paths a side "
                    "as its noise asks for. Limit: "
                    "{:.1f} % with the interval. Mean coverage: ours {:.5f}, Cycles {:.5f}.</p>\n",
                    v.settings.seeds, v.settings.spp, 100 * limits.ratio, v.coverage_ours, v.coverage_cycles);
}

std::string bin_row(const char* name, const BinTest& bins) {
  return fmt::format(
      "<tr><td>{}</td><td>{}</td><td>{}</td><td>{:.2f} %</td><td>{:.2f} %</td><td>{:.1f} %</td></tr>\n", name,
      bins.bins, bins.accepted, 100 * bins.accepted_share, 100 * bins.below_5_percent,
      100 * bins.median_detectable);
}

std::string bin_table(const Validation& v) {
  return "<table><tr><th>bins of 3 x 3 px</th><th>tested</th><th>accepted</th><th>share</th><th>p &lt; 5 "
         "%</th>"
         "<th>noticed from</th></tr>\n" +
         bin_row("inside", v.inside_bins) + bin_row("outline (1 px each side, not judged)", v.band_bins) +
         fmt::format(
             "</table><p>Welch's t test of the seeds' bin means in each channel, at {:.2g} a test (Sidak: if "
             "both "
             "renderers agree, all bins are accepted with probability 99 %). Limit: {:.1f} % accepted "
             "inside. "
             "Standard errors have a floor of 0.2 % of the bin and 0.05 % of the image's mean. About 5 % of "
             "the tests "
             "have p &lt; 5 % by chance. \"Noticed from\" is the relative difference that the median bin "
             "would "
             "not be accepted with.</p>\n",
             v.inside_bins.single_alpha, 100 * v.settings.thresholds.accepted_share);
}

std::string cost_row(const char* name, const SideCost& cost) {
  return fmt::format(
      "<tr><td>{}</td><td>{:.2f} s</td><td>{:.2f} s</td><td>{:.2f} s</td><td>{:.3g}</td></tr>\n", name,
      cost.load_s, cost.wall_s, cost.cpu_s, cost.mean_squared_error);
}

std::string cost_table(const Validation& v) {
  const SpeedRatio speed = speed_at_equal_error(v);
  return "<table><tr><th></th><th>load</th><th>an image, wall</th><th>an image, processor</th>"
         "<th>mean squared error</th></tr>\n" +
         cost_row("ours", v.our_cost) + cost_row("Cycles", v.cycles_cost) +
         fmt::format(
             "</table><p>Time to equal error: ours needs 1 / {:.2f} of Cycles' wall time and 1 / {:.2f} of "
             "its "
             "processor time (time x squared error of an image, loading apart).</p>\n",
             speed.wall, speed.cpu);
}

std::string settings_table(const Validation& v) {
  size_t different = 0;
  std::string rows;
  for (const CyclesSetting& setting : v.blender_settings) {
    different += !setting.same;
    rows += fmt::format("<tr><td>{}</td><td>{}</td><td class=\"{}\">{}</td></tr>\n", escaped(setting.name),
                        escaped(setting.wanted), setting.same ? "" : "bad", escaped(setting.found));
  }
  return fmt::format(
      "<details><summary>{} settings of Blender, read back after the last render: {}</summary><table>"
      "<tr><th>setting</th><th>wanted</th><th>found</th></tr>\n{}</table></details>\n",
      v.blender_settings.size(), different == 0 ? "all as wanted" : std::to_string(different) + " differ",
      rows);
}

}  // namespace

std::string validation_html(const Validation& v) {
  const ValidationSettings& s = v.settings;
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Validation of {0}</title>"
      "<style>{1}</style></head><body>\n<h1>{0} in {2}: ours beside Cycles</h1>\n",
      escaped(v.model_name), kStyle, escaped(v.environment_name));
  html += verdict_block(v);
  html += fmt::format(
      "<p>View {} of {}, {} x {} px, {} samples a pixel, {} seeds a side, {} bounces, Principled {}, Blender "
      "{}.{}</p>\n",
      s.view, s.view_count, s.size_px, s.size_px, s.spp, s.seeds, s.max_bounces,
      s.shading == renderer::ShadingModel::kV1 ? "v1" : "v2", escaped(v.blender_version),
      v.has_subsurface && !v.settings.subsurface ? " Subsurface scattering is set to 0 on both sides." : "");
  html += picture_block(v);
  html += "<h2>Bias by region</h2>\n" + region_table(v);
  html += "<h2>Bins</h2>\n" + bin_table(v);
  html += "<h2>Cost</h2>\n" + cost_table(v);
  html += "<h2>Settings</h2>\n" + settings_table(v);
  return html + "</body></html>\n";
}

}  // namespace ohb::validation
