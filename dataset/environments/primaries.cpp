#include "dataset/environments/primaries.h"

#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfTestFile.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "dataset/model/error.h"

namespace ohb::environments {
namespace {

using Matrix = std::array<double, 9>;
using Vector = std::array<double, 3>;

Vector times(const Matrix& m, const Vector& v) {
  Vector r{};
  for (size_t i = 0; i < 3; ++i) r[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2];
  return r;
}

Matrix times(const Matrix& a, const Matrix& b) {
  Matrix r{};
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j)
      for (size_t k = 0; k < 3; ++k) r[3 * i + j] += a[3 * i + k] * b[3 * k + j];
  return r;
}

double determinant(const Matrix& m) {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
         m[2] * (m[3] * m[7] - m[4] * m[6]);
}

Matrix inverse(const Matrix& m) {
  const double d = determinant(m);
  return {(m[4] * m[8] - m[5] * m[7]) / d, (m[2] * m[7] - m[1] * m[8]) / d, (m[1] * m[5] - m[2] * m[4]) / d,
          (m[5] * m[6] - m[3] * m[8]) / d, (m[0] * m[8] - m[2] * m[6]) / d, (m[2] * m[3] - m[0] * m[5]) / d,
          (m[3] * m[7] - m[4] * m[6]) / d, (m[1] * m[6] - m[0] * m[7]) / d, (m[0] * m[4] - m[1] * m[3]) / d};
}

/// XYZ of luminance 1.
Vector xyz_of(double x, double y) {
  return {x / y, 1, (1 - x - y) / y};
}

/// Linear RGB of the primaries to XYZ (SMPTE RP 177).
Matrix to_xyz(const Chromaticities& c) {
  Matrix columns{};
  for (size_t k = 0; k < 3; ++k) {
    const Vector primary = xyz_of(c[2 * k], c[2 * k + 1]);
    for (size_t i = 0; i < 3; ++i) columns[3 * i + k] = primary[i];
  }
  const Vector scale = times(inverse(columns), xyz_of(c[6], c[7]));
  for (size_t i = 0; i < 9; ++i) columns[i] *= scale[i % 3];
  return columns;
}

bool are_primaries(const Chromaticities& c) {
  for (const double value : c)
    if (!std::isfinite(value) || std::fabs(value) > 2) return false;
  for (size_t k = 1; k < 8; k += 2)
    if (std::fabs(c[k]) < 1e-3) return false;
  const double area = (c[2] - c[0]) * (c[5] - c[1]) - (c[4] - c[0]) * (c[3] - c[1]);
  return std::fabs(area) > 1e-3;
}

std::optional<Chromaticities> stated_chromaticities(const std::filesystem::path& file) {
  if (!Imf::isOpenExrFile(file.c_str())) return std::nullopt;
  std::optional<Imf::MultiPartInputFile> opened;
  try {
    opened.emplace(file.c_str(), 0, false);
  } catch (const std::exception& error) {
    throw InputError(file.string(), "", std::string("is a damaged EXR: ") + error.what(), "export it again");
  }
  const Imf::MultiPartInputFile& input = *opened;
  const auto* stated = input.header(0).findTypedAttribute<Imf::ChromaticitiesAttribute>("chromaticities");
  if (!stated) return std::nullopt;
  const Imf::Chromaticities& c = stated->value();
  return Chromaticities{c.red.x, c.red.y, c.green.x, c.green.y, c.blue.x, c.blue.y, c.white.x, c.white.y};
}

}  // namespace

std::array<double, 9> to_rec709(const Chromaticities& from) {
  constexpr Matrix kBradford = {0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296};
  const Vector white = times(kBradford, xyz_of(from[6], from[7]));
  const Vector wanted = times(kBradford, xyz_of(kRec709[6], kRec709[7]));
  Matrix scaled = kBradford;
  for (size_t i = 0; i < 9; ++i) scaled[i] *= wanted[i / 3] / white[i / 3];
  return times(inverse(to_xyz(kRec709)), times(inverse(kBradford), times(scaled, to_xyz(from))));
}

void convert_primaries(const std::filesystem::path& file, Image& image, std::vector<std::string>& warnings) {
  const std::optional<Chromaticities> stated = stated_chromaticities(file);
  if (!stated) return;
  double apart = 0;
  for (size_t i = 0; i < 8; ++i) apart = std::max(apart, std::fabs((*stated)[i] - kRec709[i]));
  if (apart < 2e-3) return;
  if (!are_primaries(*stated))
    throw InputError(file.string(), "attribute 'chromaticities'", "states no primaries of a colour space",
                     "remove the attribute, or export it again");
  const Matrix matrix = to_rec709(*stated);
  for (size_t i = 0; i < image.values.size(); i += 3) {
    float* rgb = &image.values[i];
    const Vector converted = times(matrix, Vector{rgb[0], rgb[1], rgb[2]});
    for (size_t c = 0; c < 3; ++c) rgb[c] = static_cast<float>(converted[c]);
  }
  warnings.push_back("states other primaries than Rec. 709 and was converted");
}

}  // namespace ohb::environments
