#include "dataset/labelling/colour_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ohb::labelling {
namespace {

using Covariance = Eigen::Matrix<float, kAppearanceCount, kAppearanceCount>;

constexpr int kIterations = 8;
/// Added to the variances: no class is narrower than the noise of a picture.
const Appearance kLeastVariance(9, 4, 4, 0.04f);
constexpr float kNothing = -50;  // density of an empty model

float squared_distance(const Appearance& a, const Appearance& b) {
  return ((a - b).cwiseAbs2().cwiseQuotient(kLeastVariance)).sum();
}

/// The heaviest sample, then ever the one that is farthest from those taken, weighed.
std::vector<Appearance> first_means(const std::vector<Appearance>& samples,
                                    const std::vector<float>& weights) {
  std::vector<Appearance> means;
  std::vector<float> nearest(samples.size(), std::numeric_limits<float>::max());
  size_t next = static_cast<size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  while (means.size() < ColourModel::kComponents) {
    means.push_back(samples[next]);
    float best = 0;
    for (size_t i = 0; i < samples.size(); ++i) {
      nearest[i] = std::min(nearest[i], squared_distance(samples[i], means.back()));
      const float score = nearest[i] * weights[i];
      if (score > best) {
        best = score;
        next = i;
      }
    }
    if (!(best > 0)) break;
  }
  return means;
}

}  // namespace

ColourModel::ColourModel(const std::vector<Appearance>& samples, const std::vector<float>& weights) {
  double total = 0;
  for (float weight : weights) total += weight;
  if (total > 0) fit(samples, weights);
}

void ColourModel::fit(const std::vector<Appearance>& samples, const std::vector<float>& weights) {
  const std::vector<Appearance> means = first_means(samples, weights);
  const size_t count = means.size();
  std::vector<std::vector<float>> share(count, std::vector<float>(samples.size(), 0));
  for (size_t i = 0; i < samples.size(); ++i) {
    size_t nearest = 0;
    for (size_t k = 1; k < count; ++k)
      if (squared_distance(samples[i], means[k]) < squared_distance(samples[i], means[nearest])) nearest = k;
    share[nearest][i] = 1;
  }
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    components_.clear();
    double total = 0;
    std::vector<double> mass(count, 0);
    for (size_t k = 0; k < count; ++k)
      for (size_t i = 0; i < samples.size(); ++i) mass[k] += double(share[k][i]) * weights[i];
    for (double m : mass) total += m;
    std::vector<size_t> kept;
    for (size_t k = 0; k < count; ++k) {
      if (!(mass[k] > 1e-4 * total)) continue;
      Eigen::Matrix<double, kAppearanceCount, 1> sum = Eigen::Matrix<double, kAppearanceCount, 1>::Zero();
      for (size_t i = 0; i < samples.size(); ++i)
        if (share[k][i] > 0) sum += double(share[k][i]) * weights[i] * samples[i].cast<double>();
      const Appearance mean = (sum / mass[k]).cast<float>();
      Eigen::Matrix<double, kAppearanceCount, kAppearanceCount> spread;
      spread.setZero();
      for (size_t i = 0; i < samples.size(); ++i) {
        if (!(share[k][i] > 0)) continue;
        const Eigen::Matrix<double, kAppearanceCount, 1> away = (samples[i] - mean).cast<double>();
        spread += double(share[k][i]) * weights[i] * away * away.transpose();
      }
      Covariance covariance = (spread / mass[k]).cast<float>();
      covariance.diagonal() += kLeastVariance;
      const Eigen::LLT<Covariance> factor(covariance);
      const Covariance lower = factor.matrixL();
      Component component;
      component.mean = mean;
      component.root = lower.inverse();
      component.log_scale = static_cast<float>(std::log(mass[k] / total)) -
                            lower.diagonal().array().log().sum() -
                            0.5f * kAppearanceCount * std::log(2 * 3.14159265f);
      components_.push_back(component);
      kept.push_back(k);
    }
    if (iteration + 1 == kIterations) break;
    for (size_t i = 0; i < samples.size(); ++i) {
      float logs[kComponents], highest = -std::numeric_limits<float>::infinity(), sum = 0;
      for (size_t k = 0; k < components_.size(); ++k) {
        const Component& of = components_[k];
        logs[k] = of.log_scale - 0.5f * (of.root * (samples[i] - of.mean)).squaredNorm();
        highest = std::max(highest, logs[k]);
      }
      for (size_t k = 0; k < components_.size(); ++k) sum += std::exp(logs[k] - highest);
      for (auto& row : share) row[i] = 0;
      for (size_t k = 0; k < components_.size(); ++k) share[kept[k]][i] = std::exp(logs[k] - highest) / sum;
    }
  }
}

float ColourModel::log_density(const Appearance& appearance) const {
  if (components_.empty()) return kNothing;
  float logs[kComponents], highest = -std::numeric_limits<float>::infinity(), sum = 0;
  for (size_t k = 0; k < components_.size(); ++k) {
    logs[k] = components_[k].log_scale -
              0.5f * (components_[k].root * (appearance - components_[k].mean)).squaredNorm();
    highest = std::max(highest, logs[k]);
  }
  for (size_t k = 0; k < components_.size(); ++k) sum += std::exp(logs[k] - highest);
  return highest + std::log(sum);
}

}  // namespace ohb::labelling
