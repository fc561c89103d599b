// What `chart` prints, writes and draws.
#include <fmt/format.h>

#include "learner/network_chart.h"
#include "renderer/validation/gnuplot.h"

namespace ohb::learner {
namespace {

using nlohmann::json;

constexpr size_t kAlbedo = 1;  // of kColumns

double mean_of_maps(const NetworkMarks& set) {
  return maps_mean(set.mean.psnr, &Psnr::masked);
}

/// Against seconds: the value of each set, with its name beside it.
std::string panel_of(const NetworkChart& chart, int column, const std::string& label) {
  std::string names = "unset label\n";
  for (const NetworkMarks& set : chart.sets) {
    const std::array<double, 3> values = {mean_of_maps(set), set.mean.psnr[kAlbedo].masked,
                                          set.mean.measures[kNormalMean_deg]};
    names +=
        fmt::format("set label {} noenhanced at {:.6g}, {:.6g} offset 0.6, 0.6 front\n",
                    validation::gnuplot_quoted(set.name), set.seconds, values[static_cast<size_t>(column)]);
  }
  return names + "set ylabel '" + label +
         fmt::format(
             "'\nplot $sets using 1:{0} with points pt 7 ps 0.9 lc rgb '#1f5fbf' notitle, "
             "$front using 1:{0} with lines lw 2 lc rgb '#1a7f37' title 'nothing is both faster and better "
             "in the mean'\n",
             column + 2);
}

std::string data_of(const char* name, const std::vector<const NetworkMarks*>& sets) {
  std::string data = fmt::format("${} << EOD\n", name);
  for (const NetworkMarks* set : sets)
    data += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g}\n", set->seconds, mean_of_maps(*set),
                        set->mean.psnr[kAlbedo].masked, set->mean.measures[kNormalMean_deg]);
  return data + "EOD\n";
}

}  // namespace

std::string network_chart_table(const NetworkChart& chart) {
  size_t width = 8;
  for (const NetworkMarks& set : chart.sets) width = std::max(width, set.name.size());
  std::string text =
      fmt::format("{} pictures of {} people at {} x {}\n\n| {:<{}} | M param. | G mult. | s a picture |",
                  chart.pictures, chart.people, chart.size_px, chart.size_px, "networks", width);
  for (size_t i = 0; i < kMaps.size(); ++i) text += fmt::format(" {:>6} |", kColumns[i]);
  text += fmt::format("  N deg |   mean |    90 %        | front |\n|{}|---------:|--------:|------------:|",
                      std::string(width + 2, '-'));
  for (size_t i = 0; i < kMaps.size(); ++i) text += "-------:|";
  text += "-------:|-------:|----------------|-------|\n";
  for (const NetworkMarks& set : chart.sets) {
    text += fmt::format("| {:<{}} | {:>8.2f} | {:>7.2f} | {:>11.3f} |", set.name, width,
                        set.million_parameters, set.billion_multiplies, set.seconds);
    for (size_t i = 0; i < kMaps.size(); ++i) text += table_cell(set.mean.psnr[i].masked);
    text += table_cell(set.mean.measures[kNormalMean_deg]) + table_cell(mean_of_maps(set)) +
            fmt::format(" {:.2f} to {:.2f} | {:<5} |\n", set.maps_mean_dB.low, set.maps_mean_dB.high,
                        set.is_on_front ? "yes" : "no");
  }
  for (const NetworkMarks& set : chart.sets)
    for (const std::string& name : set.known)
      text += fmt::format("\nTRAINED ON, not held out: {} (by {})\n", name, set.name);
  return text + fmt::format("\nthe fastest within {:g} dB of the best, by the mean of the maps: {}\n",
                            kAsGood_dB, chart.to_take().name);
}

std::string network_chart_csv(const NetworkChart& chart) {
  std::string csv = "networks,million_parameters,billion_multiplies,seconds";
  for (size_t i = 0; i < kMaps.size(); ++i) csv += fmt::format(",{}_dB", kColumns[i]);
  for (const char* name : kMeasureNames) csv += fmt::format(",{}", name);
  csv += ",mean_dB,mean_low_dB,mean_high_dB,front\n";
  for (const NetworkMarks& set : chart.sets) {
    csv += fmt::format("\"{}\",{:.4f},{:.4f},{:.5f}", set.name, set.million_parameters,
                       set.billion_multiplies, set.seconds);
    for (size_t i = 0; i < kMaps.size(); ++i) csv += fmt::format(",{:.4f}", set.mean.psnr[i].masked);
    for (const double value : set.mean.measures) csv += fmt::format(",{:.4f}", value);
    csv += fmt::format(",{:.4f},{:.4f},{:.4f},{}\n", mean_of_maps(set), set.maps_mean_dB.low,
                       set.maps_mean_dB.high, set.is_on_front ? 1 : 0);
  }
  return csv;
}

json network_chart_json(const NetworkChart& chart) {
  json out = {{"people", chart.people},   {"pictures", chart.pictures},   {"size_px", chart.size_px},
              {"as_good_dB", kAsGood_dB}, {"take", chart.to_take().name}, {"sets", json::array()}};
  for (const NetworkMarks& set : chart.sets) {
    json line = {{"name", set.name},
                 {"networks", set.networks},
                 {"million_parameters", set.million_parameters},
                 {"billion_multiplies", set.billion_multiplies},
                 {"seconds", set.seconds},
                 {"mean_dB", json_number(mean_of_maps(set))},
                 {"mean_90_dB", {json_number(set.maps_mean_dB.low), json_number(set.maps_mean_dB.high)}},
                 {"front", set.is_on_front},
                 {"trained_on", set.known}};
    for (size_t i = 0; i < kMaps.size(); ++i) line["dB"][kColumns[i]] = json_number(set.mean.psnr[i].masked);
    for (size_t i = 0; i < kMeasureCount; ++i)
      line["measures"][kMeasureNames[i]] = json_number(set.mean.measures[i]);
    out["sets"].push_back(line);
  }
  return out;
}

void draw_network_chart(const NetworkChart& chart, const std::filesystem::path& folder) {
  std::vector<const NetworkMarks*> all, front;
  for (const NetworkMarks& set : chart.sets) {
    all.push_back(&set);
    if (set.is_on_front) front.push_back(&set);
  }
  std::sort(front.begin(), front.end(),
            [](const NetworkMarks* a, const NetworkMarks* b) { return a->seconds < b->seconds; });
  const std::string settings =
      data_of("sets", all) + data_of("front", front) +
      "set grid\nset key bottom right font ',9'\nset logscale x\nset xlabel 'seconds a "
      "picture'\nset offsets graph 0.1, graph 0.25, graph 0.1, graph 0.1\n";
  validation::draw_panels(settings,
                          {panel_of(chart, 0, "mean of the maps, dB"), panel_of(chart, 1, "albedo, dB"),
                           panel_of(chart, 2, "normals off by, degrees")},
                          3, 1400, 360, folder);
}

}  // namespace ohb::learner
