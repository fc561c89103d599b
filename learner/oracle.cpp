#include "learner/oracle.h"

namespace ohb::learner {
namespace {

using shading::kMinCosine;
using shading::kMinCosineSum;
using shading::kPi;
using torch::Tensor;

/// Planes that broadcast to (B, L, H, W).
struct Fields {
  Tensor nx, ny, nz, z, roughness, f0, sss;
};

Tensor plane(const Tensor& map, int64_t channel) {
  return map.slice(1, channel, channel + 1);
}

Fields fields_of(const MaterialMaps& maps, const shading::Options& options) {
  const Tensor n = unit_normals(maps.normal);
  Fields f;
  f.nx = plane(n, 0);
  f.ny = plane(n, 1);
  f.nz = plane(n, 2);
  f.z = maps.displacement;
  f.roughness = maps.roughness.clamp_min(options.min_roughness);
  f.f0 = f0_map(maps.specular, options.specular);
  f.sss = maps.sss;
  return f;
}

Tensor light_column(const std::vector<shading::Light<double>>& lights, double shading::Light<double>::*member,
                    const Tensor& like) {
  std::vector<double> values;
  values.reserve(lights.size());
  for (const auto& light : lights) values.push_back(light.*member);
  return torch::tensor(values, torch::kDouble).to(like.scalar_type()).to(like.device()).view({1, -1, 1, 1});
}

Tensor masking(const Tensor& cosine, const Tensor& a2) {
  return 1 / (cosine + torch::sqrt(a2 + (1 - a2) * cosine * cosine));
}

}  // namespace

Tensor unit_normals(const Tensor& v) {
  const Tensor squared = v.square().sum(1, true);
  const Tensor degenerate = squared < 1e-8;
  const Tensor axis = torch::tensor({0.0, 0.0, 1.0}, v.options().requires_grad(false)).view({1, 3, 1, 1});
  return torch::where(degenerate, axis,
                      v / torch::sqrt(torch::where(degenerate, torch::ones_like(squared), squared)));
}

Tensor f0_map(const Tensor& specular, shading::SpecularEncoding encoding) {
  const Tensor s = specular.clamp(0, 1);
  if (encoding == shading::SpecularEncoding::kDisney08) return 0.08 * s;
  if (encoding == shading::SpecularEncoding::kLinearF0) return s;
  return torch::where(s <= 0.04045, s / 12.92, torch::pow((s + 0.055) / 1.055, 2.4));
}

PixelPlaces places_of(const Tensor& columns, const Tensor& rows, int64_t width_px, int64_t height_px) {
  const double pixel = 2.0 / static_cast<double>(width_px);
  return {(columns + 0.5) * pixel - 1, (0.5 * static_cast<double>(height_px) - rows - 0.5) * pixel};
}

Tensor render_maps(const MaterialMaps& maps, const std::vector<shading::Light<double>>& lights,
                   const shading::Options& options) {
  const int64_t height = maps.normal.size(2), width = maps.normal.size(3);
  const auto plain = maps.normal.options().requires_grad(false);
  return render_pixels(maps,
                       places_of(torch::arange(width, plain).view({1, 1, 1, width}),
                                 torch::arange(height, plain).view({1, 1, height, 1}), width, height),
                       lights, options);
}

Tensor render_pixels(const MaterialMaps& maps, const PixelPlaces& places,
                     const std::vector<shading::Light<double>>& lights, const shading::Options& options) {
  using Column = shading::Light<double>;
  const Fields f = fields_of(maps, options);
  const Tensor x = light_column(lights, &Column::x, f.nx) - places.u;
  const Tensor y = light_column(lights, &Column::y, f.nx) - places.v;
  const Tensor z = light_column(lights, &Column::z, f.nx) - f.z;
  const Tensor squared = (x * x + y * y + z * z).clamp_min(kMinCosine);
  const Tensor irradiance = light_column(lights, &Column::intensity, f.nx) / squared;
  const Tensor inverse = torch::rsqrt(squared);
  const Tensor lx = x * inverse, ly = y * inverse, lz = z * inverse;
  const Tensor inv_half = torch::rsqrt((2 + 2 * lz).clamp_min(1e-8));
  const Tensor hx = lx * inv_half, hy = ly * inv_half, hz = (lz + 1) * inv_half;
  const Tensor nl_raw = f.nx * lx + f.ny * ly + f.nz * lz;
  // NaN is lit, so that it shows.
  const Tensor lit = ((nl_raw <= kMinCosine) | (f.nz <= kMinCosine)).logical_not();
  const Tensor nl = nl_raw.clamp_min(kMinCosine), nv = f.nz.clamp_min(kMinCosine);
  const Tensor nh = f.nx * hx + f.ny * hy + f.nz * hz;
  const Tensor lh = lx * hx + ly * hy + lz * hz;

  const Tensor a2 = f.roughness.pow(4);
  const Tensor cross2 =
      (f.ny * hz - f.nz * hy).square() + (f.nz * hx - f.nx * hz).square() + (f.nx * hy - f.ny * hx).square();
  const Tensor t = a2 * nh * nh + cross2;
  const Tensor distribution = a2 / (kPi * t * t);
  const Tensor fresnel = f.f0 + (1 - f.f0) * (1 - lh).pow(5);
  const Tensor specular = distribution * masking(nl, a2) * masking(nv, a2) * fresnel;

  const Tensor wl = (1 - nl).pow(5), wv = (1 - nv).pow(5);
  const Tensor fss90 = f.roughness * lh * lh, fd90 = 0.5 + 2 * fss90;
  const Tensor fd = (1 + (fd90 - 1) * wl) * (1 + (fd90 - 1) * wv);
  const Tensor fss = (1 + (fss90 - 1) * wl) * (1 + (fss90 - 1) * wv);
  const Tensor ss = 1.25 * (fss * (1 / (nl + nv).clamp_min(kMinCosineSum) - 0.5) + 0.5);
  const Tensor kd = (1 - f.sss) * fd + f.sss * ss;

  // (B, 1, 3, H, W) times (B, L, 1, H, W).
  const Tensor colour = maps.diffuse.unsqueeze(1) * (kd / kPi).unsqueeze(2) + specular.unsqueeze(2);
  const Tensor radiance = colour * (nl * irradiance).unsqueeze(2);
  return torch::where(lit.unsqueeze(2), radiance, torch::zeros_like(radiance));
}

Tensor radiance_difference(const Tensor& mine, const Tensor& wanted, const shading::Options& options) {
  return (options.log_domain ? torch::log1p(mine) - torch::log1p(wanted) : mine - wanted).abs();
}

Tensor oracle_rendering_loss(const MaterialMaps& prediction, const MaterialMaps& truth, const Tensor& mask,
                             const std::vector<shading::Light<double>>& lights,
                             const shading::Options& options) {
  const Tensor foreground = (mask > 0.5).unsqueeze(1);
  const int64_t count = foreground.sum().item<int64_t>();
  if (count == 0) return torch::zeros({}, prediction.normal.options().requires_grad(false));
  const Tensor mine = render_maps(prediction, lights, options);
  const Tensor wanted = render_maps(truth, lights, options);
  const Tensor difference = radiance_difference(mine, wanted, options);
  const Tensor counted = torch::where(foreground, difference, torch::zeros_like(difference));
  return counted.sum() / static_cast<double>(count * 3 * static_cast<int64_t>(lights.size()));
}

}  // namespace ohb::learner
